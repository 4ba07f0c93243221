//! The transport of light between cells, against a plain reference in 64-bit floats and against what must hold of
//! any grid: flux, walls, symmetry, whole cells.

use crate::support::grid::{
    AXES, BLOCKED, FREE, Grid, Settings, all, cosine_lobe, dot, faces, largest, printed_step, propagate,
    propagate_as_printed, random_grid, reference_step, solid_angle,
};
use crate::support::{Stage, gpu};
use glam::{Affine3A, DVec3, UVec3, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, read_buffer};
use lightwell::render::{Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{CellSize, Clpv, Transport};
use std::f64::consts::PI;

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
fn the_device_propagates_by_the_printed_formulas() {
    let gpu = gpu();
    for cells in [[9, 5, 7], [1, 1, 1], [17, 2, 3]] {
        let grid = random_grid(cells);
        for settings in [FREE, Settings { bounce: 0, ..BLOCKED }, Settings { blocker_scale: 1.0, ..BLOCKED }] {
            let mut light: Vec<[f64; 12]> = grid.light.iter().map(|l| l.map(f64::from)).collect();
            (0..3).for_each(|_| light = printed_step(&grid, &light, settings));
            let (device, _) = propagate_as_printed(&gpu, &grid, settings, 3);
            let scale = f64::from(largest(&device)).max(1e-6);
            let pairs = device.light.iter().flatten().zip(light.iter().flatten());
            let error = pairs.map(|(&a, &b)| (f64::from(a) - b).abs()).fold(0.0, f64::max) / scale;
            assert!(error < 1e-5, "{cells:?}: {error}");
        }
    }
}

#[test]
fn a_printed_step_passes_on_the_share_of_one_over_four_pi() {
    let mut grid = Grid::new([7, 7, 7]);
    grid.add_lobe(UVec3::splat(3), Vec3::Y);
    let gpu = gpu();
    let ratio =
        propagate_as_printed(&gpu, &grid, FREE, 1).0.flux(|_| true) / propagate(&gpu, &grid, FREE, 1).0.flux(|_| true);
    assert!((ratio * 4.0 * PI - 1.0).abs() < 1e-5, "{ratio}");
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
    let cells = Clpv {
        transport: Transport::Diffusion,
        cells: [10; 3],
        cell_size: CellSize::Meters(cell),
        steps: 0,
        ..Default::default()
    };
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
