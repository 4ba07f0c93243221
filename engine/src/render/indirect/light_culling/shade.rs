//! Light of the virtual lights at every pixel.

use super::cull::Culled;
use super::{ACCEPTED, Method, Shaded, Sources, TESTED, casts_rays, image_desc};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, PassError};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::dispatch_rays;

/// Pixels times lights that one submit may test: under a second on slow adapters.
const TESTS_A_SUBMIT: u64 = 1 << 27;
/// Pixels whose rays one submit may cast.
const RAY_PIXELS_A_SUBMIT: u64 = 1 << 14;

/// Declares the pass; without masks all lights are shaded at every pixel.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    sources: Sources,
    culled: Option<Culled>,
) -> Shaded {
    let diffuse = graph.retained_texture(TESTED, image_desc(frame));
    let specular = graph.retained_texture(ACCEPTED, image_desc(frame));
    let mut pass = graph.pass("slc shade");
    let surfaces = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    surfaces.into_iter().for_each(|handle| pass.read(handle));
    let (texels, bound) = (sources.texels, sources.bound);
    pass.read(texels);
    pass.read(bound);
    let masks = culled.map(|culled| [culled.masks, culled.slices]);
    masks.into_iter().flatten().for_each(|handle| pass.read(handle));
    let shaded = Shaded { diffuse: pass.write(diffuse), specular: pass.write(specular) };
    let rays = casts_rays(&method.settings);
    pass.key(&(method.key(frame), rays.then(|| (frame.geometry_key(), frame.media_key()))));
    let (frame, method) = (frame.clone(), method.clone());
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let views = surfaces.map(|handle| cx.view(handle));
        let targets = [shaded.diffuse, shaded.specular].map(|handle| cx.view(handle));
        let (texels, bound) = (cx.view(texels), cx.buffer(bound).clone());
        let masks = masks.map(|masks| masks.map(|handle| cx.buffer(handle).clone()));
        let scene = frame.rays.filter(|_| rays);
        let mut key = match scene {
            Some(scene) => scene.shader("indirect/light_culling/shade.wgsl", "main").def("RAYS", ShaderDef::Flag(true)),
            None if rays => return Err(PassError::message("the scene is not ready for rays".to_owned())),
            None => ComputeKey::new("indirect/light_culling/shade.wgsl", "main"),
        };
        match masks {
            None => key = key.def("UNCULLED", ShaderDef::Flag(true)),
            Some(_) => key = method.sliced(key),
        }
        for (shines, without) in method.lobes().into_iter().zip(["NO_DIFFUSE", "NO_SPECULAR"]) {
            if !shines {
                key = key.def(without, ShaderDef::Flag(true));
            }
        }
        let has_sky_map = scene.is_some() && method.sky_map(&frame).is_some();
        if has_sky_map {
            key = key.def("SKY_MAP", ShaderDef::Flag(true));
        }
        let [width, height] = frame.view.size.map(u64::from);
        cx.counts().texels += width * height;
        let batch = subsets_a_submit(&method, width * height, rays, masks.is_none());
        let mut first = 0;
        while first < method.subsets() {
            let count = batch.min(method.subsets() - first);
            let culling = method.uniform(gpu, &frame, first);
            let mut group = vec![
                ("culling", Binding::Buffer(&culling)),
                ("base_color", Binding::Texture(&views[0])),
                ("normal", Binding::Texture(&views[1])),
                ("object", Binding::Texture(&views[2])),
                ("depth", Binding::Texture(&views[3])),
                ("light_texels", Binding::Texture(&texels)),
                ("bound", Binding::Buffer(&bound)),
                ("diffuse", Binding::Texture(&targets[0])),
                ("specular", Binding::Texture(&targets[1])),
            ];
            if has_sky_map {
                group.push(("sky", Binding::Texture(frame.gpu_scene.sky())));
            }
            if let Some([masks, slices]) = &masks {
                group.extend([("masks", Binding::Buffer(masks)), ("slices", Binding::Buffer(slices))]);
            }
            cx.work(u64::from(count), u64::from(batch))?;
            let groups = [method.tiles[0], method.tiles[1], count];
            match scene {
                Some(scene) => {
                    dispatch_rays(cx, &key, &group, scene, groups)?;
                }
                None => cx.dispatch(&key, &group, groups)?,
            }
            first += count;
        }
        Ok(())
    });
    shaded
}

/// Long work is cut into several submits.
fn subsets_a_submit(method: &Method, pixels: u64, rays: bool, unculled: bool) -> u32 {
    let pixels_a_subset = (pixels / u64::from(method.subsets())).max(1);
    // Where nothing is culled every light casts a ray.
    let by_rays = match (rays, unculled) {
        (true, true) => RAY_PIXELS_A_SUBMIT / 16,
        (true, false) => RAY_PIXELS_A_SUBMIT,
        (false, _) => u64::MAX,
    } / pixels_a_subset;
    let by_tests = TESTS_A_SUBMIT / (pixels_a_subset * 2 * u64::from(method.lights).max(1));
    by_rays.min(by_tests).clamp(1, u64::from(method.subsets())) as u32
}
