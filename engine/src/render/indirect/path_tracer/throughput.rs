//! How many paths a second the device traces, against the host over the same hierarchies.

use super::host::HostTracer;
use super::path_trace::{PathTracer, TraceError};
use super::{Estimate, TraceSettings};
use crate::gpu::Gpu;
use crate::measure::Image;
use crate::scene::{Scene, SceneView};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

/// Both tracers on the same paths: the same scene, pixels, samples and random numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Throughput {
    /// Paths that each of both traced.
    pub paths: u64,
    /// Threads that the host used.
    pub threads: usize,
    /// Paths a second on the device, the best of the rounds.
    pub device: f64,
    /// Paths a second on the host, the best of the rounds.
    pub host: f64,
    /// What the device traced.
    pub device_image: Estimate,
    /// What the host traced.
    pub host_image: Estimate,
}

/// Traces the same paths on the device and on the host in turns, `rounds` times. None if the scene has materials that
/// the host's tracer does not know: it is for diffuse surfaces without textures.
///
/// # Errors
/// If the device's tracer fails.
pub fn measure_throughput(
    gpu: &Gpu,
    scene: &Scene,
    view: &SceneView,
    settings: &TraceSettings,
    samples: u32,
    rounds: u32,
) -> Result<Option<Throughput>, TraceError> {
    if !HostTracer::knows(scene) {
        return Ok(None);
    }
    let mut tracer = PathTracer::new(gpu);
    // Pipelines are made before any clock runs.
    tracer.begin(gpu, scene, &SceneView { size: [8, 8], ..view.clone() }, settings)?;
    tracer.advance(gpu, 1)?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let paths = u64::from(view.size[0]) * u64::from(view.size[1]) * u64::from(samples);
    let (mut device, mut host) = (0.0_f64, 0.0_f64);
    let mut images = None;
    for _ in 0..rounds.max(1) {
        tracer.restart();
        tracer.begin(gpu, scene, view, settings)?;
        let start = Instant::now();
        tracer.advance(gpu, samples)?;
        device = device.max(paths as f64 / start.elapsed().as_secs_f64());
        let host_tracer = HostTracer::new(scene, &tracer.scene().bvh, view, *settings);
        let start = Instant::now();
        let traced = trace_on_host(&host_tracer, view.size, samples, threads);
        host = host.max(paths as f64 / start.elapsed().as_secs_f64());
        images = Some((tracer.estimate(gpu)?, traced));
    }
    let Some((device_image, host_image)) = images else { return Ok(None) };
    Ok(Some(Throughput { paths, threads, device, host, device_image, host_image }))
}

/// Rows are dealt out to the threads one by one.
fn trace_on_host(tracer: &HostTracer, size: [u32; 2], samples: u32, threads: usize) -> Estimate {
    let [width, height] = size;
    let next = AtomicU32::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let y = next.fetch_add(1, Ordering::Relaxed);
            if y >= height {
                return done;
            }
            done.push((y, (0..width).map(|x| trace_pixel(tracer, [x, y], samples)).collect::<Vec<_>>()));
        }
    };
    let mut rows: Vec<(u32, Vec<[[f32; 3]; 4]>)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads.into_iter().filter_map(|thread| thread.join().ok()).flatten().collect()
    });
    rows.sort_by_key(|(y, _)| *y);
    let counts = [samples.div_ceil(2), if samples > 1 { samples / 2 } else { 1 }];
    let image = |half: usize, part: usize| {
        let source = if samples > 1 { half } else { 0 };
        let mean = |pixel: &[[f32; 3]; 4]| pixel[2 * source + part].map(|value| value / counts[half] as f32);
        let pixels = rows.iter().flat_map(|(_, row)| row).map(mean).collect();
        Image::from_pixels(width, height, pixels).unwrap_or_else(|| Image::filled(width, height, [0.0; 3]))
    };
    Estimate { direct: [image(0, 0), image(1, 0)], indirect: [image(0, 1), image(1, 1)], samples }
}

/// Sums as on the device: direct and indirect light of the even samples, then of the odd ones.
fn trace_pixel(tracer: &HostTracer, pixel: [u32; 2], samples: u32) -> [[f32; 3]; 4] {
    let mut sums = [glam::Vec3::ZERO; 4];
    for sample in 0..samples {
        let light = tracer.path(pixel, sample);
        let half = 2 * (sample & 1) as usize;
        sums[half] += light.direct;
        sums[half + 1] += light.indirect;
    }
    sums.map(|sum| sum.to_array())
}
