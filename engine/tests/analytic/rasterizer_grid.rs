//! Rasterizers of cards put the corners of triangles on a grid of 1/256 of a pixel (Vulkan 1.3, `subPixelPrecisionBits`),
//! and depths follow. Software drivers interpolate depths between the corners as they were, so the grid is made here, in
//! the vertex shaders; light must be what it is without.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, GpuOptions, default_shader_dir};
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, GatherRays, InstantRadiosity, Quality, StochasticLightCulling, Transport};
use std::path::Path;

const SHADOW_SIZE: u32 = 128;
const RSM_SIZE: u32 = 64;

/// Moves the corner that a shader puts out to the grid of an image of that many pixels.
fn snapping(text: &str, size: &str) -> String {
    let placed = text.find("out.clip = view.clip_from_world").expect("the shader places a corner");
    let end = placed + text[placed..].find('\n').expect("a line") + 1;
    let snap = format!(
        "    if out.clip.w > 1e-3 {{
        let steps = 128.0 * {size};
        out.clip = vec4f(round(out.clip.xy / out.clip.w * steps) / steps * out.clip.w, out.clip.zw);
    }}\n"
    );
    format!("{}{snap}{}", &text[..end], &text[end..])
}

/// Copies all shaders, those that place corners with the grid.
fn copy(from: &Path, to: &Path, below: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("shaders") {
        let entry = entry.expect("an entry");
        let (to, below) = (to.join(entry.file_name()), below.join(entry.file_name()));
        if entry.path().is_dir() {
            copy(&entry.path(), &to, &below);
            continue;
        }
        let text = std::fs::read_to_string(entry.path()).expect("text");
        let size = match below.to_str() {
            Some("lib/surface.wgsl") => "vec2f(view.size)".to_owned(),
            Some("shadows/shadow_map.wgsl") => format!("{SHADOW_SIZE}.0"),
            Some("shadows/reflective.wgsl") => format!("{RSM_SIZE}.0"),
            _ => String::new(),
        };
        let text = if size.is_empty() { text } else { snapping(&text, &size) };
        std::fs::write(to, text).expect("written");
    }
}

fn gpu_with_grid(folder: &Path) -> Gpu {
    copy(&default_shader_dir().expect("shaders"), folder, Path::new(""));
    Gpu::headless(&GpuOptions { adapter: None, shader_dir: folder.into() }).expect("a Vulkan driver")
}

/// A lamp and a box that stands askew in a room, in few pixels: the fewer, the wider the grid.
fn room(edge: u32) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), edge);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.5, 0.3));
    let place = Affine3A::from_rotation_y(0.4);
    let place = Affine3A::from_translation(Vec3::new(-0.9, -1.1, -0.8)) * place;
    stage.add(Shape::Box { size: [0.9, 1.8, 0.7] }, Vec3::splat(0.6), place);
    let light = stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2), Vec3::NEG_Y);
    (light.shadow_size, light.rsm_size) = (SHADOW_SIZE, RSM_SIZE);
    stage
}

/// Of all pixels, in both images.
fn means(gpus: [&Gpu; 2], stage: &Stage, gi: GiMethod, layer: Layer) -> [f64; 2] {
    gpus.map(|gpu| {
        let image = stage.render(gpu, gi, layer);
        image.rgba.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / image.rgba.len() as f64
    })
}

#[test]
fn all_light_is_what_it_is_without_the_grid() {
    let folder = tempfile::tempdir().expect("a folder");
    let (without, with) = (gpu(), gpu_with_grid(folder.path()));
    let mut is_moved = false;
    let rays = Clpv { gather_rays: GatherRays::Count(32), quality: Quality::Low, ..Default::default() };
    let diffusion = Clpv { transport: Transport::Diffusion, ..Default::default() };
    for edge in [32, 96] {
        let mut stage = room(edge);
        stage.scene.vpl = Some(InstantRadiosity { particles: 64, ..Default::default() });
        stage.scene.slc = Some(StochasticLightCulling { rsm_size: RSM_SIZE, ..Default::default() });
        let cases = [
            ("direct light", &rays, GiMethod::NONE, Layer::Direct, 0.002),
            ("light volumes with rays", &rays, GiMethod::CLPV, Layer::Indirect, 0.006),
            ("diffusion", &diffusion, GiMethod::CLPV, Layer::Indirect, 0.006),
            ("instant radiosity", &rays, GiMethod::VPL, Layer::Indirect, 0.006),
            ("stochastic light culling", &rays, GiMethod::SLC, Layer::Indirect, 0.006),
        ];
        for (name, volumes, gi, layer, bound) in cases {
            stage.clpv(Vec3::ZERO, volumes.clone());
            let [before, after] = means([&without, &with], &stage, gi, layer);
            println!("{name}, {edge} pixels: {before:.6} without, {after:.6} with ({:+.4})", after / before - 1.0);
            is_moved |= before != after;
            assert!((after / before - 1.0).abs() < bound, "{name}, {edge} pixels: {before} without, {after} with");
        }
    }
    assert!(is_moved, "the grid moved nothing");
}
