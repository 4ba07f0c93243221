//! Light of the virtual lights at every pixel.

use super::cull::Culled;
use super::{ACCEPTED, Method, Shaded, Sources, TESTED, casts_rays, image_desc};
use crate::gpu::ComputeKey;
use crate::graph::{Counts, Graph, Tracked};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;

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
    let rays = casts_rays(&method.settings);
    let mut pass = graph.compute("slc shade", ComputeKey::new("indirect/light_culling/shade.wgsl", "main"));
    if rays {
        frame.bind_ray_surfaces(&mut pass);
        pass.flag("RAYS", true);
        if let Some(map) = method.sky_map(frame) {
            pass.flag("SKY_MAP", true);
            pass.tracked("sky", Tracked::texture(frame.gpu_scene.sky(), &map.id));
        }
    }
    match culled {
        None => pass.flag("UNCULLED", true),
        Some(culled) => {
            method.define_slices(&mut pass);
            pass.read("masks", culled.masks);
            pass.read("slices", culled.slices);
        }
    }
    let [diffuse_shines, specular_shines] = method.lobes();
    pass.flag("NO_DIFFUSE", !diffuse_shines);
    pass.flag("NO_SPECULAR", !specular_shines);
    gbuffer.bind(&mut pass);
    pass.read("light_texels", sources.texels);
    pass.read("bound", sources.bound);
    let shaded = Shaded { diffuse: pass.write("diffuse", diffuse), specular: pass.write("specular", specular) };
    let pixels = frame.view.size.map(u64::from).iter().product();
    pass.count(Counts { texels: pixels, ..Counts::default() });
    let batch = subsets_a_submit(method, pixels, rays, culled.is_none());
    for first in (0..method.subsets()).step_by(batch as usize) {
        let count = batch.min(method.subsets() - first);
        let mut step = pass.step("main");
        step.uniform("culling", &method.values(frame, first));
        step.work(count.into(), batch.into());
        step.in_groups([method.tiles[0], method.tiles[1], count]);
    }
    pass.finish();
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
