//! A grid of light and blockers, stepped on the device and by a plain reference in 64-bit floats.

use encase::ShaderType;
use glam::{DVec3, UVec3, Vec3};
use lightwell::gpu::{Binding, ComputeKey, Gpu, read_buffer};
use std::f64::consts::PI;

/// 1/(2√π) and √3/(2√π).
const BANDS: [f64; 2] = [0.282_094_791_773_878_1, 0.488_602_511_902_919_9];

/// `Volume` of `lib/volume.wgsl`.
#[derive(ShaderType)]
struct VolumeUniform {
    origin: Vec3,
    cell: f32,
    cells: UVec3,
    padding: u32,
}

/// `Propagation` of `indirect/light_volumes/diffusion/propagate.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub struct Settings {
    pub occlusion: u32,
    pub bounce: u32,
    pub blocker_scale: f32,
    pub padding: u32,
}

pub const FREE: Settings = Settings { occlusion: 0, bounce: 0, blocker_scale: 0.0, padding: 0 };
pub const BLOCKED: Settings = Settings { occlusion: 1, bounce: 1, blocker_scale: 4.0 / 3.0, padding: 0 };

/// Light in the cells and blockers on their corners, laid out as in the shaders.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub cells: UVec3,
    pub light: Vec<[f32; 12]>,
    pub blockers: Vec<[f32; 8]>,
}

impl Grid {
    pub fn new(cells: [u32; 3]) -> Self {
        let cells = UVec3::from(cells);
        Self {
            cells,
            light: vec![[0.0; 12]; cells.element_product() as usize],
            blockers: vec![[0.0; 8]; (cells + 1).element_product() as usize],
        }
    }

    pub fn cell(&self, at: UVec3) -> usize {
        ((at.z * self.cells.y + at.y) * self.cells.x + at.x) as usize
    }

    pub fn corner(&self, at: UVec3) -> usize {
        ((at.z * (self.cells.y + 1) + at.y) * (self.cells.x + 1) + at.x) as usize
    }

    /// A diffuse source of unit flux in each channel.
    pub fn add_lobe(&mut self, at: UVec3, normal: Vec3) {
        let cell = self.cell(at);
        let lobe = cosine_lobe(normal.as_dvec3()).map(|c| c / PI);
        for channel in 0..3 {
            for (sum, c) in self.light[cell][4 * channel..4 * channel + 4].iter_mut().zip(lobe) {
                *sum += c as f32;
            }
        }
    }

    /// A full wall on all corners with this coordinate along an axis.
    pub fn add_wall(&mut self, axis: usize, plane: u32, normal: Vec3, reflectance: f32) {
        for corner in all(self.cells + 1).filter(|c| c[axis] == plane) {
            let index = self.corner(corner);
            let b = cosine_lobe(normal.as_dvec3()).map(|c| c as f32);
            self.blockers[index] = [b[0], b[1], b[2], b[3], reflectance, reflectance, reflectance, 1.0];
        }
    }

    /// Flux [W] of the first channel in the cells that the filter takes, cells being of edge 1.
    pub fn flux(&self, filter: impl Fn(UVec3) -> bool) -> f64 {
        let cells = all(self.cells).filter(|&c| filter(c));
        cells.map(|c| f64::from(self.light[self.cell(c)][0])).sum::<f64>() * (4.0 * PI).sqrt()
    }
}

pub fn all(size: UVec3) -> impl Iterator<Item = UVec3> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec3::new(x, y, z))))
}

/// Y_lm in a direction, in the order (1, y, z, x).
fn basis(d: DVec3) -> [f64; 4] {
    [BANDS[0], BANDS[1] * d.y, BANDS[1] * d.z, BANDS[1] * d.x]
}

/// A_l·Y_lm of a normal.
pub fn cosine_lobe(n: DVec3) -> [f64; 4] {
    let y = basis(n);
    [PI * y[0], 2.0 / 3.0 * PI * y[1], 2.0 / 3.0 * PI * y[2], 2.0 / 3.0 * PI * y[3]]
}

pub fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub const AXES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// Solid angle of a rectangle at a distance, seen from the origin, from its corners.
fn rectangle(distance: f64, u: [f64; 2], v: [f64; 2]) -> f64 {
    let corner = |u: f64, v: f64| (u * v / (distance * (distance * distance + u * u + v * v).sqrt())).atan();
    corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])
}

/// Solid angle of a neighbour's face from the centre of a cell: the far one, or one across.
pub fn solid_angle(far: bool) -> f64 {
    if far { rectangle(1.5, [-0.5, 0.5], [-0.5, 0.5]) } else { rectangle(0.5, [0.5, 1.5], [-0.5, 0.5]) }
}

/// The faces of the neighbour along `travel` but the one in common: normal, direction to its centre, solid angle.
pub fn faces(travel: DVec3) -> impl Iterator<Item = (DVec3, DVec3, f64)> {
    AXES.into_iter().filter(move |&f| f != -travel).map(move |f| {
        let towards = (travel + 0.5 * f).normalize();
        (f, towards, solid_angle(f == travel))
    })
}

/// One step by the formulas of Šefčík 2016, 3.10.3, without regard to speed. `clamp`: negative intensity is no light.
pub fn reference_step(grid: &Grid, light: &[[f64; 12]], settings: Settings, clamp: bool) -> Vec<[f64; 12]> {
    let mut next = vec![[0.0; 12]; light.len()];
    for cell in all(grid.cells) {
        for travel in AXES {
            let (blocked, reflectance) = blocker(grid, cell, travel);
            let against = f64::from(settings.blocker_scale) * dot(blocked, basis(-travel));
            let stopped = if settings.occlusion == 1 { against.clamp(0.0, 1.0) } else { 0.0 };
            for channel in 0..3 {
                let of = |lights: &[f64; 12]| -> [f64; 4] { std::array::from_fn(|i| lights[4 * channel + i]) };
                let own = of(&light[grid.cell(cell)]);
                let mut back = 0.0;
                let target = cell.as_ivec3() + travel.as_ivec3();
                let inside = target.min_element() >= 0 && target.cmplt(grid.cells.as_ivec3()).all();
                for (normal, towards, angle) in faces(travel) {
                    let intensity = dot(own, basis(towards));
                    let flux = angle * if clamp { intensity.max(0.0) } else { intensity };
                    back += stopped * reflectance[channel] * flux;
                    if inside {
                        let lobe = cosine_lobe(normal).map(|c| c * (1.0 - stopped) * flux / PI);
                        let to = &mut next[grid.cell(target.as_uvec3())];
                        (0..4).for_each(|i| to[4 * channel + i] += lobe[i]);
                    }
                }
                if settings.bounce == 1 && stopped > 0.0 {
                    let to = &mut next[grid.cell(cell)];
                    let whole = (4.0 * PI).sqrt() * blocked[0];
                    (0..4).for_each(|i| to[4 * channel + i] += back * blocked[i] / whole);
                }
            }
        }
    }
    next
}

/// One step by the formulas as Šefčík 2016 prints them in 3.10.3, with the flux that equation 3.7 lacks.
pub fn printed_step(grid: &Grid, light: &[[f64; 12]], settings: Settings) -> Vec<[f64; 12]> {
    let mut next = vec![[0.0; 12]; light.len()];
    for cell in all(grid.cells) {
        for travel in AXES {
            let neighbour = cell.as_ivec3() - travel.as_ivec3();
            if neighbour.min_element() < 0 || !neighbour.cmplt(grid.cells.as_ivec3()).all() {
                continue;
            }
            let source = light[grid.cell(neighbour.as_uvec3())];
            let (between, _) = blocker(grid, cell, -travel);
            let (farthest, reflectance) = blocker(grid, cell, travel);
            let blocking =
                |b: [f64; 4], d: DVec3| (f64::from(settings.blocker_scale) * dot(b, basis(d))).clamp(0.0, 1.0);
            for (normal, towards, angle) in faces(travel) {
                let passed = if settings.occlusion == 1 { 1.0 - blocking(between, -towards) } else { 1.0 };
                let share = if settings.bounce == 1 { blocking(farthest, -towards) } else { 0.0 };
                let lobe = cosine_lobe(normal);
                let to = &mut next[grid.cell(cell)];
                for channel in 0..3 {
                    let own: [f64; 4] = std::array::from_fn(|i| source[4 * channel + i]);
                    let flux = angle / (4.0 * PI) * dot(own, basis(towards)).max(0.0) * passed;
                    let reflected = reflectance[channel] * share * flux;
                    (0..4).for_each(|i| to[4 * channel + i] += flux / PI * lobe[i] + reflected * farthest[i]);
                }
            }
        }
    }
    next
}

/// Mean blocker and reflectance over the corners of the face of a cell along `travel`.
fn blocker(grid: &Grid, cell: UVec3, travel: DVec3) -> ([f64; 4], [f64; 3]) {
    let mut sum = [0.0; 8];
    for corner in all(UVec3::splat(2)) {
        let outwards = 2.0 * corner.as_dvec3() - 1.0;
        if outwards.dot(travel) > 0.0 {
            let values = grid.blockers[grid.corner(cell + corner)];
            (0..8).for_each(|i| sum[i] += f64::from(values[i]));
        }
    }
    let area = sum[7].max(1e-12);
    ([0, 1, 2, 3].map(|i| 0.25 * sum[i]), [4, 5, 6].map(|i| sum[i] / area))
}

/// Steps on the device: the light after the last, and the sum of all with what was there before.
pub fn propagate(gpu: &Gpu, grid: &Grid, settings: Settings, steps: u32) -> (Grid, Grid) {
    propagate_by(gpu, "indirect/light_volumes/diffusion/propagate.wgsl", grid, settings, steps)
}

/// The same by the printed formulas.
pub fn propagate_as_printed(gpu: &Gpu, grid: &Grid, settings: Settings, steps: u32) -> (Grid, Grid) {
    propagate_by(gpu, "indirect/light_volumes/diffusion/propagate_printed.wgsl", grid, settings, steps)
}

fn propagate_by(gpu: &Gpu, shader: &'static str, grid: &Grid, settings: Settings, steps: u32) -> (Grid, Grid) {
    let pipeline = gpu.pipelines.compute(gpu, &ComputeKey::new(shader, "step")).expect("a valid shader");
    let volume = gpu.uniform("volume", &VolumeUniform { origin: Vec3::ZERO, cell: 1.0, cells: grid.cells, padding: 0 });
    let settings = gpu.uniform("settings", &settings);
    let blockers = gpu.storage("blockers", &grid.blockers, wgpu::BufferUsages::empty());
    let more = wgpu::BufferUsages::COPY_SRC;
    let sum = gpu.storage("sum", &grid.light, more);
    let mut source = gpu.storage("source", &grid.light, more);
    for _ in 0..steps {
        let gathered = gpu.storage("gathered", &vec![[0.0_f32; 12]; grid.light.len()], more);
        let resources = [
            ("volume", Binding::Buffer(&volume)),
            ("propagation", Binding::Buffer(&settings)),
            ("source", Binding::Buffer(&source)),
            ("gathered", Binding::Buffer(&gathered)),
            ("accumulated", Binding::Buffer(&sum)),
            ("blockers", Binding::Buffer(&blockers)),
        ];
        let group = pipeline.bind(gpu, 0, &resources).expect("all bindings");
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline.compute().expect("a compute pipeline"));
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(grid.cells.x.div_ceil(8), grid.cells.y.div_ceil(8), grid.cells.z);
        }
        gpu.queue.submit([encoder.finish()]);
        source = gathered;
    }
    let read = |buffer| Grid { light: read_buffer(gpu, buffer).expect("readable"), ..grid.clone() };
    (read(&source), read(&sum))
}

/// Numbers in −1..1 that are the same in every run.
fn noise() -> impl FnMut() -> f32 {
    let mut state = 12345_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    }
}

/// Light everywhere and blockers of all directions and fillings.
pub fn random_grid(cells: [u32; 3]) -> Grid {
    let mut grid = Grid::new(cells);
    let mut random = noise();
    for light in &mut grid.light {
        *light = std::array::from_fn(|i| if i % 4 == 0 { 1.0 + random() } else { random() });
    }
    for blocker in &mut grid.blockers {
        let normal = DVec3::from_array([random(), random(), random()].map(f64::from)).normalize_or_zero();
        let area = (random() * 1.5).max(0.0);
        let lobe = cosine_lobe(normal).map(|c| c as f32 * area);
        let tint = [random(), random(), random()].map(|c| (0.5 + 0.5 * c) * area);
        *blocker = [lobe[0], lobe[1], lobe[2], lobe[3], tint[0], tint[1], tint[2], area];
    }
    grid
}

pub fn largest(grid: &Grid) -> f32 {
    grid.light.iter().flatten().fold(0.0, |m, c| m.max(c.abs()))
}
