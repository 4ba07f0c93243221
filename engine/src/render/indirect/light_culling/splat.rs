//! Splatting: every light is drawn over the pixels that its range covers (Dachsbacher and Stamminger 2006). Kept to
//! compare, as table 2 of the paper of 2017 has it.

use super::{ACCEPTED, Method, Shaded, Sources, TESTED, casts_rays, image_desc};
use crate::gpu::{Binding, ComputeKey, Gpu, RasterKey};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::world::LightCulling;
use glam::Vec3;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, TextureFormat, TextureUsages};

/// Triangles around a range (2017, section 7).
const TRIANGLES: u32 = 80;

/// Whether lights can be drawn one by one, if that is wanted.
///
/// # Errors
/// What stands in the way, in words. Nothing else is drawn in its place: a comparison would not say so.
pub(super) fn check(gpu: &Gpu, method: &Method, size: [u32; 2]) -> Result<(), RenderError> {
    let wrong = |what: &str| {
        let message = format!("stochastic light culling: `Splatting` {what}: use `slc.culling=Tiled`");
        Err(RenderError::method(message))
    };
    let [width, height] = atlas_size(method, size);
    let most = gpu.limits.max_texture_dimension_2d;
    match method.settings.culling {
        LightCulling::Splatting if casts_rays(&method.settings) => wrong("casts no shadow rays"),
        LightCulling::Splatting if !gpu.features.contains(wgpu::Features::FLOAT32_BLENDABLE) => {
            wrong("needs an adapter that blends 32-bit floats")
        }
        LightCulling::Splatting if width.max(height) > most => wrong(&format!(
            "draws into an image of {width}×{height} pixels, and this adapter's are at most {most} wide"
        )),
        _ => Ok(()),
    }
}

/// The images of all subsets side by side \[pixels\].
fn atlas_size(method: &Method, size: [u32; 2]) -> [u32; 2] {
    size.map(|edge| edge.div_ceil(method.settings.interleave) * method.settings.interleave)
}

/// Corners of [`TRIANGLES`] triangles around the unit sphere, three each, counter-clockwise seen from outside: an
/// icosahedron whose faces are cut into four, blown up until its faces touch the sphere.
fn corners() -> Vec<[f32; 4]> {
    let triangles: Vec<[Vec3; 3]> = icosahedron().into_iter().flat_map(quartered).collect();
    let least = triangles.iter().map(|&triangle| distance_of_plane(triangle)).fold(1.0, f32::min);
    // A share more, since the device rounds what the tests of pixels do not.
    let scale = 1.0001 / least;
    triangles.into_iter().flatten().map(|corner| (corner * scale).extend(0.0).into()).collect()
}

fn icosahedron() -> Vec<[Vec3; 3]> {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let mut points = Vec::new();
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        points.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    // Edges are 2 long, and all other distances longer.
    let is_edge = |a: Vec3, b: Vec3| (a.distance(b) - 2.0).abs() < 0.1;
    let mut faces = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        for (j, &b) in points.iter().enumerate().skip(i + 1).filter(|&(_, &b)| is_edge(a, b)) {
            for &c in points[j + 1..].iter().filter(|&&c| is_edge(a, c) && is_edge(b, c)) {
                let outward = (b - a).cross(c - a).dot(a) > 0.0;
                let face = if outward { [a, b, c] } else { [a, c, b] };
                faces.push(face.map(Vec3::normalize));
            }
        }
    }
    faces
}

/// Four triangles on the sphere in place of one.
fn quartered([a, b, c]: [Vec3; 3]) -> [[Vec3; 3]; 4] {
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| (p + q).normalize());
    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
}

/// Distance of a triangle's plane from the origin.
fn distance_of_plane([a, b, c]: [Vec3; 3]) -> f32 {
    (b - a).cross(c - a).normalize().dot(a)
}

/// The instances that are drawn: lights of the diffuse lobe, and then those of the other.
fn instances(method: &Method) -> std::ops::Range<u32> {
    let [diffuse, specular] = method.lobes();
    let first = if diffuse { 0 } else { method.lights };
    let end = if specular { 2 * method.lights } else { method.lights };
    first..end
}

/// Declares the drawing of all lights, and the way back from the atlas of subsets to the image.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    sources: Sources,
) -> Shaded {
    let atlas = declare_atlas(graph, frame, gbuffer, method, sources);
    let diffuse = graph.retained_texture(TESTED, image_desc(frame));
    let specular = graph.retained_texture(ACCEPTED, image_desc(frame));
    let mut pass = graph.compute("slc gather", ComputeKey::new("indirect/light_culling/splat.wgsl", "gather"));
    pass.uniform("culling", &method.values(frame, 0));
    pass.read("diffuse_atlas", atlas.diffuse);
    pass.read("specular_atlas", atlas.specular);
    let shaded = Shaded { diffuse: pass.write("diffuse", diffuse), specular: pass.write("specular", specular) };
    pass.step("gather").over_uncounted(frame.view.size);
    pass.finish();
    shaded
}

fn declare_atlas<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    sources: Sources,
) -> Shaded {
    let n = method.settings.interleave;
    let [width, height] = atlas_size(method, frame.view.size);
    let part = [width / n, height / n];
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, TextureFormat::Rgba32Float, usage);
    let diffuse = graph.retained_texture("slc diffuse atlas", desc.clone());
    let specular = graph.retained_texture("slc specular atlas", desc);
    // By hand: the subsets of a row share a render pass, each with a viewport and bindings of its own.
    let mut pass = graph.pass("slc splat");
    let surfaces = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth, sources.texels];
    surfaces.into_iter().for_each(|handle| pass.read(handle));
    let buffers = [sources.ranges, sources.bound];
    buffers.into_iter().for_each(|handle| pass.read(handle));
    let atlas = Shaded { diffuse: pass.write(diffuse), specular: pass.write(specular) };
    pass.key(&method.key(frame));
    let (frame, method) = (frame.clone(), method.clone());
    pass.execute(move |cx| {
        for row in 0..n {
            cx.work(1, 1)?;
            draw_row(cx, &frame, &method, [surfaces.as_slice(), &[atlas.diffuse, atlas.specular]], buffers, row, part)?;
        }
        Ok(())
    });
    atlas
}

/// Draws the lights of one row of subsets.
fn draw_row(
    cx: &mut PassContext,
    frame: &Frame,
    method: &Method,
    [surfaces, targets]: [&[Handle<Texture>]; 2],
    buffers: [Handle<crate::graph::Buffer>; 2],
    row: u32,
    part: [u32; 2],
) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let n = method.settings.interleave;
    let surfaces: Vec<wgpu::TextureView> = surfaces.iter().map(|handle| cx.view(*handle)).collect();
    let targets: Vec<wgpu::TextureView> = targets.iter().map(|handle| cx.view(*handle)).collect();
    let buffers = buffers.map(|handle| cx.buffer(handle).clone());
    let corners = gpu.constants("corners around a range", &corners());
    let pipeline = gpu.pipelines.raster(gpu, &raster_key())?;
    let Some(raster) = pipeline.raster() else {
        return Err(PassError::message("`indirect/light_culling/splat.wgsl` made no raster pipeline".to_owned()));
    };
    let mut groups = Vec::new();
    for column in 0..n {
        let culling = method.uniform(gpu, frame, row * n + column);
        let group = [
            ("culling", Binding::Buffer(&culling)),
            ("base_color", Binding::Texture(&surfaces[0])),
            ("normal", Binding::Texture(&surfaces[1])),
            ("object", Binding::Texture(&surfaces[2])),
            ("depth", Binding::Texture(&surfaces[3])),
            ("light_texels", Binding::Texture(&surfaces[4])),
            ("ranges", Binding::Buffer(&buffers[0])),
            ("bound", Binding::Buffer(&buffers[1])),
            ("corners", Binding::Buffer(&corners)),
        ];
        groups.push(pipeline.bind(gpu, 0, &group)?);
    }
    let counts = cx.counts();
    counts.draws += u64::from(n);
    counts.triangles += u64::from(n) * u64::from(TRIANGLES) * instances(method).len() as u64;
    let load = if row == 0 { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    let attachment = |view| {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
    };
    let mut pass = cx.render_pass(&wgpu::RenderPassDescriptor {
        label: Some("slc splat"),
        color_attachments: &[attachment(&targets[0]), attachment(&targets[1])],
        ..Default::default()
    });
    pass.set_pipeline(raster);
    for (column, group) in (0..n).zip(&groups) {
        let [x, y] = [column * part[0], row * part[1]];
        pass.set_viewport(x as f32, y as f32, part[0] as f32, part[1] as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, part[0], part[1]);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3 * TRIANGLES, instances(method));
    }
    Ok(())
}

fn raster_key() -> RasterKey {
    let add =
        BlendComponent { src_factor: BlendFactor::One, dst_factor: BlendFactor::One, operation: BlendOperation::Add };
    let target = wgpu::ColorTargetState {
        format: TextureFormat::Rgba32Float,
        blend: Some(BlendState { color: add, alpha: add }),
        write_mask: wgpu::ColorWrites::ALL,
    };
    RasterKey {
        shader: "indirect/light_culling/splat.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
        vertex_buffers: Vec::new(),
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Front), ..Default::default() },
        depth: None,
        targets: vec![Some(target.clone()), Some(target)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is drawn covers the range: no face cuts the sphere, and all together are around it.
    #[test]
    fn eighty_triangles_hold_the_sphere() {
        let corners = corners();
        assert_eq!(corners.len(), 3 * TRIANGLES as usize);
        let mut solid_angle = 0.0;
        for triangle in corners.as_chunks::<3>().0 {
            let [a, b, c] = triangle.map(|[x, y, z, _]| Vec3::new(x, y, z));
            assert!(distance_of_plane([a, b, c]) >= 1.0, "{a} {b} {c} cut the sphere, or face inwards");
            assert!([a, b, c].iter().all(|corner| corner.length() < 1.1), "{a} {b} {c} lie far outside");
            // Van Oosterom and Strackee 1983.
            let [a, b, c] = [a, b, c].map(Vec3::normalize);
            solid_angle += 2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        }
        assert!((solid_angle / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-4, "{solid_angle}");
    }
}
