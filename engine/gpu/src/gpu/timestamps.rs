//! GPU time of named stretches of a command encoder.

use super::Gpu;
use super::readback::{Mapping, take_mapped};

/// A pair of timestamps for each of up to `capacity` stretches; without the feature, times are not known.
pub struct TimestampQueries {
    set: Option<Set>,
    capacity: u32,
    names: Vec<String>,
    /// Stretches begun and not yet ended; none for one that there was no room for.
    open: Vec<Option<u32>>,
    /// The times on their way back.
    arriving: Option<Mapping>,
}

struct Set {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

impl TimestampQueries {
    /// Room for that many stretches (at most 2048).
    pub fn new(gpu: &Gpu, capacity: u32) -> Self {
        let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let capacity = capacity.clamp(1, 2048);
        let buffer = |usage| {
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 16 * u64::from(capacity),
                usage,
                mapped_at_creation: false,
            })
        };
        let set = gpu.features.contains(wanted).then(|| Set {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * capacity + 1,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            staging: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
        });
        Self { set, capacity, names: Vec::new(), open: Vec::new(), arriving: None }
    }

    /// Forgets the stretches of the last frame.
    pub fn reset(&mut self) {
        self.names.clear();
        self.open.clear();
    }

    /// Begins a stretch, which may lie inside another; [`TimestampQueries::end`] must follow. False if there is no
    /// room for it: it is then not timed.
    pub fn begin(&mut self, encoder: &mut wgpu::CommandEncoder, name: &str) -> bool {
        let index = self.names.len() as u32;
        if index >= self.capacity {
            self.open.push(None);
            return false;
        }
        self.open.push(Some(index));
        self.names.push(name.to_string());
        if let Some(set) = &self.set {
            self.write(encoder, &set.queries, 2 * index);
        }
        true
    }

    /// Ends the innermost stretch.
    pub fn end(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if let (Some(Some(index)), Some(set)) = (self.open.pop(), &self.set) {
            self.write(encoder, &set.queries, 2 * index + 1);
        }
    }

    /// Writes a timestamp, and one that nobody reads: lavapipe queues a timestamp with the next piece of rasterisation,
    /// and only a further timestamp flushes it. Alone it may be taken after the dispatch that follows it.
    fn write(&self, encoder: &mut wgpu::CommandEncoder, queries: &wgpu::QuerySet, index: u32) {
        encoder.write_timestamp(queries, index);
        encoder.write_timestamp(queries, 2 * self.capacity);
    }

    /// Records the copy of the times; the last thing before the encoder is submitted.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = 2 * self.names.len() as u32;
        if let (Some(set), true) = (&self.set, count > 0) {
            encoder.resolve_query_set(&set.queries, 0..count, &set.resolved, 0);
            encoder.copy_buffer_to_buffer(&set.resolved, 0, &set.staging, 0, 8 * u64::from(count));
        }
    }

    /// Asks for the times of what was submitted. Nothing may be timed again before [`TimestampQueries::take`] has given
    /// them.
    pub fn request(&mut self) {
        self.arriving = self.set.as_ref().filter(|_| !self.names.is_empty()).map(|set| Mapping::begin(&set.staging));
    }

    /// Each stretch's time \[ms\], none where the device cannot tell. Without a wait this gives nothing as long as what
    /// was requested has not arrived.
    pub fn take(&mut self, gpu: &Gpu, wait: bool) -> Option<Vec<(String, Option<f64>)>> {
        let arrived = match &mut self.arriving {
            Some(arriving) => arriving.arrived(gpu, wait)?.is_ok(),
            None => false,
        };
        self.arriving = None;
        let staging = self.set.as_ref().map(|set| &set.staging).filter(|_| arrived);
        let ticks = staging.and_then(|staging| {
            take_mapped(staging, |bytes| {
                bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned::<u64>).collect::<Vec<_>>()
            })
            .ok()
        });
        let period = f64::from(gpu.queue.get_timestamp_period());
        let time = |index: usize| {
            let ticks = ticks.as_ref()?;
            let span = ticks.get(2 * index + 1)?.saturating_sub(*ticks.get(2 * index)?);
            Some(span as f64 * period * 1e-6)
        };
        Some(self.names.iter().cloned().enumerate().map(|(index, name)| (name, time(index))).collect())
    }

    /// Waits for the device and gives each stretch's time \[ms\], none where the device cannot tell.
    pub fn read(&mut self, gpu: &Gpu) -> Vec<(String, Option<f64>)> {
        self.request();
        self.take(gpu, true).unwrap_or_default()
    }
}

impl Gpu {
    /// Timers for up to 512 stretches of a frame.
    pub fn timestamps(&self) -> TimestampQueries {
        TimestampQueries::new(self, 512)
    }
}
