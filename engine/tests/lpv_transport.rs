//! The transport of light between cells, against a plain reference in 64-bit floats and against what must hold of
//! any grid: flux, walls, symmetry, whole cells.

mod support;

use encase::ShaderType;
use glam::{Affine3A, DVec3, UVec3, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Binding, ComputeKey, Gpu, read_buffer};
use lightwell::render::{Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{CellSize, Clpv};
use std::f64::consts::PI;
use support::{Stage, gpu};

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

/// `Propagation` of `lpv/propagate.wgsl`.
#[derive(ShaderType, Clone, Copy)]
struct Settings {
    occlusion: u32,
    bounce: u32,
    blocker_scale: f32,
    padding: u32,
}

const FREE: Settings = Settings { occlusion: 0, bounce: 0, blocker_scale: 0.0, padding: 0 };
const BLOCKED: Settings = Settings { occlusion: 1, bounce: 1, blocker_scale: 4.0 / 3.0, padding: 0 };

/// Light in the cells and blockers on their corners, laid out as in the shaders.
#[derive(Clone, Debug, PartialEq)]
struct Grid {
    cells: UVec3,
    light: Vec<[f32; 12]>,
    blockers: Vec<[f32; 8]>,
}

impl Grid {
    fn new(cells: [u32; 3]) -> Self {
        let cells = UVec3::from(cells);
        Self {
            cells,
            light: vec![[0.0; 12]; cells.element_product() as usize],
            blockers: vec![[0.0; 8]; (cells + 1).element_product() as usize],
        }
    }

    fn cell(&self, at: UVec3) -> usize {
        ((at.z * self.cells.y + at.y) * self.cells.x + at.x) as usize
    }

    fn corner(&self, at: UVec3) -> usize {
        ((at.z * (self.cells.y + 1) + at.y) * (self.cells.x + 1) + at.x) as usize
    }

    /// A diffuse source of unit flux in each channel.
    fn add_lobe(&mut self, at: UVec3, normal: Vec3) {
        let cell = self.cell(at);
        let lobe = cosine_lobe(normal.as_dvec3()).map(|c| c / PI);
        for channel in 0..3 {
            for (sum, c) in self.light[cell][4 * channel..4 * channel + 4].iter_mut().zip(lobe) {
                *sum += c as f32;
            }
        }
    }

    /// A full wall on all corners with this coordinate along an axis.
    fn add_wall(&mut self, axis: usize, plane: u32, normal: Vec3, reflectance: f32) {
        for corner in all(self.cells + 1).filter(|c| c[axis] == plane) {
            let index = self.corner(corner);
            let b = cosine_lobe(normal.as_dvec3()).map(|c| c as f32);
            self.blockers[index] = [b[0], b[1], b[2], b[3], reflectance, reflectance, reflectance, 1.0];
        }
    }

    /// Flux [W] of the first channel in the cells that the filter takes, cells being of edge 1.
    fn flux(&self, filter: impl Fn(UVec3) -> bool) -> f64 {
        let cells = all(self.cells).filter(|&c| filter(c));
        cells.map(|c| f64::from(self.light[self.cell(c)][0])).sum::<f64>() * (4.0 * PI).sqrt()
    }
}

fn all(size: UVec3) -> impl Iterator<Item = UVec3> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec3::new(x, y, z))))
}

/// Y_lm in a direction, in the order (1, y, z, x).
fn basis(d: DVec3) -> [f64; 4] {
    [BANDS[0], BANDS[1] * d.y, BANDS[1] * d.z, BANDS[1] * d.x]
}

/// A_l·Y_lm of a normal.
fn cosine_lobe(n: DVec3) -> [f64; 4] {
    let y = basis(n);
    [PI * y[0], 2.0 / 3.0 * PI * y[1], 2.0 / 3.0 * PI * y[2], 2.0 / 3.0 * PI * y[3]]
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

const AXES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// Solid angle of a rectangle at a distance, seen from the origin, from its corners.
fn rectangle(distance: f64, u: [f64; 2], v: [f64; 2]) -> f64 {
    let corner = |u: f64, v: f64| (u * v / (distance * (distance * distance + u * u + v * v).sqrt())).atan();
    corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])
}

/// Solid angle of a neighbour's face from the centre of a cell: the far one, or one across.
fn solid_angle(far: bool) -> f64 {
    if far { rectangle(1.5, [-0.5, 0.5], [-0.5, 0.5]) } else { rectangle(0.5, [0.5, 1.5], [-0.5, 0.5]) }
}

/// The faces of the neighbour along `travel` but the one in common: normal, direction to its centre, solid angle.
fn faces(travel: DVec3) -> impl Iterator<Item = (DVec3, DVec3, f64)> {
    AXES.into_iter().filter(move |&f| f != -travel).map(move |f| {
        let towards = (travel + 0.5 * f).normalize();
        (f, towards, solid_angle(f == travel))
    })
}

/// One step by the formulas of Šefčík 2016, 3.10.3, without regard to speed. `clamp`: negative intensity is no light.
fn reference_step(grid: &Grid, light: &[[f64; 12]], settings: Settings, clamp: bool) -> Vec<[f64; 12]> {
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
fn propagate(gpu: &Gpu, grid: &Grid, settings: Settings, steps: u32) -> (Grid, Grid) {
    let pipeline = gpu.pipelines.compute(gpu, &ComputeKey::new("lpv/propagate.wgsl", "step")).expect("a valid shader");
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
fn random_grid(cells: [u32; 3]) -> Grid {
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

fn largest(grid: &Grid) -> f32 {
    grid.light.iter().flatten().fold(0.0, |m, c| m.max(c.abs()))
}

#[test]
fn thirty_solid_angles_are_the_whole_sphere() {
    assert!((solid_angle(true) - 0.400_669_684_6).abs() < 1e-9, "{}", solid_angle(true));
    assert!((solid_angle(false) - 0.423_431_354_4).abs() < 1e-9, "{}", solid_angle(false));
    let sum: f64 = AXES.into_iter().flat_map(faces).map(|(_, _, angle)| angle).sum();
    assert!((sum - 4.0 * PI).abs() < 1e-12, "{sum}");
}

#[test]
fn the_device_propagates_as_the_reference_does() {
    let gpu = gpu();
    for cells in [[9, 5, 7], [1, 1, 1], [17, 2, 3]] {
        let grid = random_grid(cells);
        for settings in [FREE, Settings { bounce: 0, ..BLOCKED }, Settings { blocker_scale: 1.0, ..BLOCKED }, BLOCKED] {
            let mut light: Vec<[f64; 12]> = grid.light.iter().map(|l| l.map(f64::from)).collect();
            let mut sum = light.clone();
            for _ in 0..4 {
                light = reference_step(&grid, &light, settings, true);
                for (sum, light) in sum.iter_mut().zip(&light) {
                    (0..12).for_each(|i| sum[i] += light[i]);
                }
            }
            let (last, accumulated) = propagate(&gpu, &grid, settings, 4);
            for (device, reference) in [(last, light), (accumulated, sum)] {
                let scale = f64::from(largest(&device)).max(1e-6);
                let pairs = device.light.iter().flatten().zip(reference.iter().flatten());
                let error = pairs.map(|(&a, &b)| (f64::from(a) - b).abs()).fold(0.0, f64::max) / scale;
                assert!(error < 1e-5, "{cells:?}: {error}");
            }
        }
    }
}

#[test]
fn flux_is_kept_exactly_but_for_the_clamped_back_of_a_lobe() {
    let mut grid = Grid::new([11, 11, 11]);
    grid.add_lobe(UVec3::splat(5), Vec3::Y);
    let flux = |light: &[[f64; 12]]| light.iter().map(|l| l[0]).sum::<f64>() * (4.0 * PI).sqrt();
    let start: Vec<[f64; 12]> = grid.light.iter().map(|l| l.map(f64::from)).collect();
    // Four steps do not reach the border.
    let mut light = start.clone();
    for step in 1..=4 {
        light = reference_step(&grid, &light, FREE, false);
        assert!((flux(&light) - 1.0).abs() < 1e-6, "step {step}: {}", flux(&light));
    }
    let clamped = flux(&reference_step(&grid, &start, FREE, true));
    assert!((clamped - 1.13).abs() < 0.01, "{clamped}");
    let (device, _) = propagate(&gpu(), &grid, FREE, 1);
    assert!((device.flux(|_| true) - clamped).abs() < 1e-5);
}

#[test]
fn a_full_wall_lets_nothing_through_and_returns_what_it_reflects() {
    let gpu = gpu();
    for axis in 0..3 {
        for (sign, reflectance) in [(1.0, 0.0), (-1.0, 0.25), (1.0, 0.5), (-1.0, 1.0)] {
            // Light flies from its cell towards a wall that faces it.
            let mut towards = Vec3::ZERO;
            towards[axis] = sign;
            let mut grid = Grid::new([6, 6, 6]);
            let plane = if sign > 0.0 { 4 } else { 2 };
            grid.add_wall(axis, plane, -towards, reflectance);
            let mut at = UVec3::splat(3);
            at[axis] = if sign > 0.0 { plane - 1 } else { plane };
            grid.add_lobe(at, towards);
            let behind = |c: UVec3| if sign > 0.0 { c[axis] >= plane } else { c[axis] < plane };

            let flux_with = |settings| propagate(&gpu, &grid, settings, 1).0;
            let (free, blocked) = (flux_with(FREE), flux_with(BLOCKED));
            let absorbed = flux_with(Settings { bounce: 0, ..BLOCKED });
            assert!(free.flux(behind) > 0.4, "{}", free.flux(behind));
            assert!(blocked.flux(behind).abs() < 1e-6, "{} W behind the wall", blocked.flux(behind));
            // The wall's edge also stops a part of what passes along it: two of the corners there are its own.
            let stopped = free.flux(|_| true) - absorbed.flux(|_| true);
            let returned = blocked.flux(|_| true) - absorbed.flux(|_| true);
            let share = returned / stopped;
            assert!((share - f64::from(reflectance)).abs() < 1e-5, "{returned} of {stopped} W returned");
        }
    }
}

#[test]
fn the_back_of_a_one_sided_blocker_stops_nothing() {
    let gpu = gpu();
    let mut grid = Grid::new([4, 4, 4]);
    grid.add_wall(1, 2, Vec3::Y, 1.0);
    grid.add_lobe(UVec3::new(1, 1, 2), Vec3::Y);
    let (free, _) = propagate(&gpu, &grid, FREE, 1);
    let (blocked, _) = propagate(&gpu, &grid, BLOCKED, 1);
    assert_eq!(free.flux(|c| c.y == 2), blocked.flux(|c| c.y == 2));
}

/// A cell's coefficients or a corner's blocker with axis `i` of the new frame taken from axis `from[i]` of the old,
/// times `sign[i]`.
fn turned_vector(v: &[f32], from: [usize; 3], sign: [f32; 3]) -> [f32; 4] {
    // (1, y, z, x): axis x stands at 3, y at 1, z at 2.
    let place = [3, 1, 2];
    let mut out = [v[0]; 4];
    for i in 0..3 {
        out[place[i]] = sign[i] * v[place[from[i]]];
    }
    out
}

fn turned(grid: &Grid, from: [usize; 3], sign: [f32; 3]) -> Grid {
    let mut out = Grid::new(from.map(|i| grid.cells[i]));
    let source = |at: UVec3, last: UVec3| {
        let mut old = UVec3::ZERO;
        for i in 0..3 {
            old[from[i]] = if sign[i] > 0.0 { at[i] } else { last[from[i]] - at[i] };
        }
        old
    };
    for at in all(out.cells) {
        let old = grid.light[grid.cell(source(at, grid.cells - 1))];
        let channels = [0, 4, 8].map(|c| turned_vector(&old[c..c + 4], from, sign));
        let index = out.cell(at);
        out.light[index] = std::array::from_fn(|i| channels[i / 4][i % 4]);
    }
    for at in all(out.cells + 1) {
        let old = grid.blockers[grid.corner(source(at, grid.cells))];
        let lobe = turned_vector(&old[..4], from, sign);
        let index = out.corner(at);
        out.blockers[index] = std::array::from_fn(|i| if i < 4 { lobe[i] } else { old[i] });
    }
    out
}

#[test]
fn mirrors_and_quarter_turns_of_the_grid_mirror_and_turn_the_light() {
    let gpu = gpu();
    let grid = random_grid([6, 5, 7]);
    let (plain, _) = propagate(&gpu, &grid, BLOCKED, 5);
    for (from, sign) in [
        ([0, 1, 2], [-1.0, 1.0, 1.0]),
        ([0, 1, 2], [1.0, -1.0, 1.0]),
        ([0, 1, 2], [1.0, 1.0, -1.0]),
        ([1, 0, 2], [-1.0, 1.0, 1.0]),
        ([0, 2, 1], [1.0, -1.0, 1.0]),
        ([2, 1, 0], [1.0, 1.0, -1.0]),
        ([1, 2, 0], [1.0, 1.0, 1.0]),
    ] {
        let (light, _) = propagate(&gpu, &turned(&grid, from, sign), BLOCKED, 5);
        let expected = turned(&plain, from, sign);
        let error = light.light.iter().flatten().zip(expected.light.iter().flatten());
        let error = error.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / largest(&plain);
        assert!(error < 1e-5, "axes {from:?}, signs {sign:?}: {error}");
    }
}

#[test]
fn a_shift_by_whole_cells_gives_the_same_bits() {
    let gpu = gpu();
    let scene = |shift: UVec3| {
        let mut grid = Grid::new([14, 13, 12]);
        grid.add_lobe(UVec3::new(5, 5, 5) + shift, Vec3::new(0.48, 0.6, -0.64));
        let patch = random_grid([2, 2, 2]);
        for corner in all(patch.cells + 1) {
            let index = grid.corner(corner + UVec3::new(5, 6, 4) + shift);
            grid.blockers[index] = patch.blockers[patch.corner(corner)];
        }
        grid
    };
    let shift = UVec3::new(2, 1, 1);
    let (here, _) = propagate(&gpu, &scene(UVec3::ZERO), BLOCKED, 4);
    let (there, _) = propagate(&gpu, &scene(shift), BLOCKED, 4);
    for cell in all(UVec3::splat(9)).map(|c| c + 1) {
        assert_eq!(here.light[here.cell(cell)], there.light[there.cell(cell + shift)], "{cell}");
    }
}

#[test]
fn no_light_stays_no_light_and_powers_of_two_scale_exactly() {
    let gpu = gpu();
    let grid = random_grid([5, 6, 4]);
    let dark = Grid { light: vec![[0.0; 12]; grid.light.len()], ..grid.clone() };
    assert!(propagate(&gpu, &dark, BLOCKED, 3).1.light.iter().flatten().all(|&c| c == 0.0));
    let (once, _) = propagate(&gpu, &grid, BLOCKED, 3);
    for power in [-30, 7, 40] {
        let factor = 2.0_f32.powi(power);
        let bright = Grid { light: grid.light.iter().map(|l| l.map(|c| c * factor)).collect(), ..grid.clone() };
        let (scaled, _) = propagate(&gpu, &bright, BLOCKED, 3);
        for (a, b) in once.light.iter().flatten().zip(scaled.light.iter().flatten()) {
            assert_eq!(a * factor, *b, "2^{power}");
        }
    }
}

#[test]
fn a_white_closed_box_never_runs_away() {
    // Walls on all six sides, one cell inside the border; a source off its middle.
    let gpu = gpu();
    let mut grid = Grid::new([8, 8, 8]);
    for axis in 0..3 {
        for (plane, sign) in [(1, 1.0), (7, -1.0)] {
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            for corner in all(grid.cells + 1).filter(|c| c[axis] == plane) {
                // Where walls meet, each corner keeps one wall's vector, as merged views do.
                let index = grid.corner(corner);
                let b = cosine_lobe(normal.as_dvec3()).map(|c| c as f32);
                grid.blockers[index] = [b[0], b[1], b[2], b[3], 1.0, 1.0, 1.0, 1.0];
            }
        }
    }
    grid.add_lobe(UVec3::new(3, 4, 2), Vec3::Y);
    let mut last = 1.0;
    let mut peak = 0.0_f64;
    for block in 0..10 {
        let (next, _) = propagate(&gpu, &grid, BLOCKED, 100);
        grid.light = next.light;
        let flux = grid.flux(|_| true);
        assert!(flux.is_finite() && flux >= 0.0, "{flux}");
        if block > 0 {
            assert!(
                flux <= last * (1.0 + 1e-5),
                "{last} W grew to {flux} W in steps {}..{}",
                100 * block,
                100 * block + 100
            );
        }
        last = flux;
        peak = peak.max(flux);
    }
    assert!(peak < 2.0, "{peak} W of 1 W");
}

#[test]
fn light_of_all_directions_is_looked_up_as_it_is_with_two_thirds() {
    // Radiance L from everywhere sends πL through every face of a cell. Cells of intensity I send their six faces'
    // share, 4πI/6: so I = 3/2·L, and E = πL asks for k = 2/3.
    let radiance = 1.25;
    let intensity = 1.5 * radiance;
    let mut grid = Grid::new([3, 3, 3]);
    let constant = ((4.0 * PI).sqrt() * intensity) as f32;
    grid.light = vec![std::array::from_fn(|i| if i % 4 == 0 { constant } else { 0.0 }); 27];
    let (next, _) = propagate(&gpu(), &grid, FREE, 1);
    let middle = next.light[next.cell(UVec3::ONE)].map(f64::from);
    assert!((middle[0] - f64::from(constant)).abs() < 1e-5, "the middle does not keep its light: {middle:?}");
    let through_a_face = 4.0 * PI * intensity / 6.0;
    assert!((through_a_face - PI * radiance).abs() < 1e-12);
    for normal in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, -0.48, 0.64)] {
        let light = [middle[0], middle[1], middle[2], middle[3]];
        let irradiance = 2.0 / 3.0 * dot(light, cosine_lobe(-normal));
        assert!((irradiance / (PI * radiance) - 1.0).abs() < 1e-5, "{irradiance}");
    }
}

/// A white floor at a height in units of cells, and a lamp above: the buffers of light and blockers.
fn floor_at(gpu: &Gpu, cell: f32, height: f32, shape: LightShape) -> Grid {
    let mut stage = Stage::new(Vec3::new(0.1, 3.0, 0.2), Vec3::ZERO, 16);
    let slanted = Vec3::new(0.31, -1.0, 0.17);
    let lower = Vec3::new(-5.0, -2.5, -5.0) * cell;
    let floor = Affine3A::from_translation(Vec3::new(0.0, lower.y + height * cell, 0.0));
    stage.add(Shape::Plane { size: [6.0, 6.0], subdivisions: [1, 1] }, Vec3::ONE, floor);
    stage.light(shape, Vec3::ONE, Vec3::new(0.03, 7.0 * cell, 0.01), slanted).rsm_size = 256;
    let cells = Clpv { cells: [10; 3], cell_size: CellSize::Meters(cell), steps: 0, ..Default::default() };
    stage.clpv(lower + 5.0 * cell, cells);
    let mut renderer = Renderer::new(gpu);
    stage.render_with(gpu, &mut renderer, &RenderSettings { only: Layer::Indirect, ..Default::default() });
    let buffer = |name| renderer.buffer(name).unwrap_or_else(|| panic!("{name} is not kept"));
    Grid {
        cells: UVec3::splat(10),
        light: read_buffer(gpu, buffer("inject, cascade 0")).expect("readable"),
        blockers: read_buffer(gpu, buffer("blockers, cascade 0")).expect("readable"),
    }
}

#[test]
fn a_wall_anywhere_between_the_corners_is_one_whole_wall() {
    let gpu = gpu();
    let full = cosine_lobe(DVec3::Y)[0];
    for shape in [LightShape::Directional, LightShape::Point, LightShape::Spot { inner: 1.2, outer: 1.3 }] {
        let heights = [3.0, 3.2, 3.5, 3.8].into_iter().flat_map(|height| [0.25, 0.3, 0.37].map(|cell| (cell, height)));
        for (cell, height) in heights {
            let grid = floor_at(&gpu, cell, height, shape);
            let (mut least, mut planes, mut layers) = (f64::MAX, Vec::new(), Vec::new());
            for y in 0..=10 {
                let inner =
                    all(UVec3::splat(10)).filter(|c| (2..9).contains(&c.x) && (2..9).contains(&c.z) && c.y == y);
                let seen: Vec<f64> =
                    inner.map(|c| f64::from(grid.blockers[grid.corner(c)][0]) / full).filter(|&b| b > 0.0).collect();
                if !seen.is_empty() {
                    planes.push(y);
                    least = seen.iter().copied().fold(least, f64::min);
                }
                let light = grid.flux(|c| c.y == y);
                if light > 0.0 {
                    layers.push((y, light));
                }
            }
            assert_eq!(planes.len(), 1, "{shape:?}, floor at {height} cells: blockers in planes {planes:?}");
            // The lobe is that of the plane's normal, whose area a square of texels samples to some percent.
            assert!(least > 0.8, "{shape:?}, floor at {height} cells: only {least} of a wall");
            if shape == LightShape::Directional {
                assert_eq!(layers.len(), 1, "floor at {height} cells: light in layers {layers:?}");
                assert!(layers[0].0 >= planes[0], "the light lies behind the wall: {layers:?}, {planes:?}");
            }
        }
    }
}
