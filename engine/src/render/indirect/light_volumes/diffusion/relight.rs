//! Indirect light of the visible surfaces, looked up in the volumes.

use super::ambient_occlusion;
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, Graph, Handle, PassBindings, Texture, TextureDesc};
use crate::render::direct::{Region, region_around};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::volume::{MAX_CASCADES, Volume, VolumeUniform};
use crate::scene::{Aabb, SceneView};
use crate::world::{Clpv, Formulas};
use encase::ShaderType;
use glam::{UVec2, Vec3};

/// `Cascade` of `lib/relight.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct CascadeUniform {
    volume: VolumeUniform,
    fade_center: Vec3,
    fade_cells: f32,
    fade_half: Vec3,
    padding: f32,
}

impl CascadeUniform {
    pub(in crate::render::indirect) fn new(volume: &Volume, fade_cells: f32) -> Self {
        Self {
            volume: volume.uniform(),
            fade_center: volume.fade_center,
            fade_cells,
            fade_half: volume.fade_half,
            padding: 0.0,
        }
    }
}

/// `Relight` of `lib/relight.wgsl`.
#[derive(ShaderType, Clone)]
pub(crate) struct RelightUniform {
    cascades: [CascadeUniform; MAX_CASCADES],
    count: u32,
    gain: f32,
    offset: f32,
    damping: f32,
}

/// `Region` of `indirect/light_volumes/diffusion/relight.wgsl`.
#[derive(ShaderType)]
pub(crate) struct RelitRegionUniform {
    origin: UVec2,
    size: UVec2,
}

const SHADER: &str = "indirect/light_volumes/diffusion/relight.wgsl";

/// Edge of a tile of pixels: that of a workgroup.
const TILE: u32 = 8;

/// The pixels in which the volumes may be seen, in whole tiles (Šefčík 2016, section 8.2); empty: none.
fn relit_region(volumes: &[Volume], view: &SceneView) -> Region {
    let size = UVec2::from(view.size);
    let full = Region { origin: UVec2::ZERO, size };
    let bounds = volumes.iter().fold(Aabb::EMPTY, |all, volume| all.union(&volume.bounds()));
    // Lookups take points a little outside for points inside.
    let coarsest = volumes.iter().fold(0.0_f32, |cell, volume| cell.max(volume.cell));
    let reach = Aabb { min: bounds.min - 0.01 * coarsest, max: bounds.max + 0.01 * coarsest };
    if !(reach.min.is_finite() && reach.max.is_finite()) {
        return full;
    }
    let Some(seen) = region_around(&reach, view) else {
        return Region { origin: UVec2::ZERO, size: UVec2::ZERO };
    };
    // A pixel more on all sides, for the rounding of the projection.
    let low = seen.origin.saturating_sub(UVec2::ONE) / TILE * TILE;
    let high = ((seen.origin + seen.size + 1 + TILE - 1) / TILE * TILE).min(size);
    Region { origin: low, size: high - low }
}

/// Says how many tiles are left out.
fn report_tiles(graph: &mut Graph, region: Region, size: [u32; 2]) {
    let tiles = |size: UVec2| u64::from(size.x.div_ceil(TILE)) * u64::from(size.y.div_ceil(TILE));
    let (all, relit) = (tiles(size.into()), tiles(region.size));
    if relit < all {
        graph.skip("relight, tiles", format!("{} of {all} tiles of {TILE}×{TILE} pixels show no volume", all - relit));
    }
}

/// Declares the pass; `lit` are the propagated volumes, finest first. The result is reflected radiance.
pub(in crate::render::indirect) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    settings: &Clpv,
    volumes: &[Volume],
    lit: &[Handle<Buffer>],
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let region = relit_region(volumes, frame.view);
    report_tiles(graph, region, frame.view.size);
    let visibility = ambient_occlusion::declare(graph, frame, gbuffer, settings, region);
    let indirect = graph.retained_texture("indirect radiance", desc);
    let mut pass = graph.compute("relight", ComputeKey::new(SHADER, "main"));
    frame.bind_view(&mut pass);
    pass.uniform("relight", &uniform(settings, volumes));
    pass.read("base_color", gbuffer.base_color);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    bind_cascades(&mut pass, lit);
    let indirect = pass.write("indirect", indirect);
    if region.size != UVec2::from(frame.view.size) {
        pass.step("clear").over_uncounted(frame.view.size);
    }
    if region.size != UVec2::ZERO {
        let mut step = pass.step("main");
        step.uniform("region", &RelitRegionUniform { origin: region.origin, size: region.size });
        if let Some(visibility) = visibility {
            step.flag("AMBIENT_OCCLUSION", true);
            step.read("visibility", visibility);
        }
        step.over(region.size.into());
    }
    pass.finish();
    indirect
}

/// Binds four cascades. One that is not there is never read; the finest stands in for it.
pub(in crate::render::indirect) fn bind_cascades(pass: &mut PassBindings, lit: &[Handle<Buffer>]) {
    let names = ["light_finest", "light_second", "light_third", "light_coarsest"];
    for (level, name) in names.into_iter().enumerate() {
        pass.read(name, lit[if level < lit.len() { level } else { 0 }]);
    }
}

pub(in crate::render::indirect) fn uniform(settings: &Clpv, volumes: &[Volume]) -> RelightUniform {
    let finite = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
    let coarsest = volumes.len() - 1;
    let fade = |level: usize| if level < coarsest { settings.border_fade } else { settings.outside_fade };
    let cascade = |level: usize| CascadeUniform::new(&volumes[level.min(coarsest)], finite(fade(level)));
    RelightUniform {
        cascades: std::array::from_fn(cascade),
        count: volumes.len() as u32,
        gain: finite(settings.gain),
        // The thesis looks light up at the surface itself.
        offset: if settings.formulas == Formulas::Printed { 0.0 } else { 0.5 },
        damping: finite(settings.gradient_damping),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneCamera, SceneId, ViewProjection};
    use glam::{Affine3A, Mat4, Quat};

    fn view(eye: Vec3, turn: Quat, projection: ViewProjection) -> SceneView {
        let camera = SceneCamera {
            id: SceneId(1),
            name: "camera".into(),
            world_from_view: Affine3A::from_rotation_translation(turn, eye),
            projection,
            near: 0.05,
            far: None,
            primary: true,
            lens: Default::default(),
            grading: None,
        };
        SceneView { camera, size: [203, 117], jitter: [0.3, -0.2] }
    }

    /// The pixel that shows a point before the camera.
    fn pixel(view: &SceneView, point: Vec3) -> Option<UVec2> {
        let clip_from_world: Mat4 = view.clip_from_world();
        let clip = clip_from_world * point.extend(1.0);
        if clip.w <= 0.0 || !(0.0..=1.0).contains(&(clip.z / clip.w)) {
            return None;
        }
        let at = glam::Vec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5;
        let size = UVec2::from(view.size);
        let at = at * size.as_vec2();
        (at.cmpge(glam::Vec2::ZERO).all() && at.cmplt(size.as_vec2()).all()).then(|| at.as_uvec2())
    }

    /// No pixel is left out that shows a point of a volume, or nearly one: what is left out is black all the same.
    #[test]
    fn all_points_of_all_volumes_are_relit() {
        let mut state = 1_u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let (mut partial, mut shown) = (0, 0);
        for case in 0..400 {
            let mut vector = |size: f32| Vec3::new(random() - 0.5, random() - 0.5, random() - 0.5) * size;
            let (eye, turn, origin, other) = (vector(6.0), vector(6.0), vector(8.0), vector(8.0));
            let turn = Quat::from_scaled_axis(turn);
            let projection = match case % 3 {
                0 => ViewProjection::Orthographic { height: 4.0 },
                _ => ViewProjection::Perspective { vertical_fov: 0.9 },
            };
            let view = view(eye, turn, projection);
            let volume = |origin: Vec3, cell: f32| Volume {
                origin,
                cell,
                cells: glam::UVec3::new(4, 7, 5),
                fade_center: origin,
                fade_half: Vec3::ONE,
            };
            let volumes = [volume(origin, 0.1), volume(other, 0.2)];
            let region = relit_region(&volumes, &view);
            let end = region.origin + region.size;
            assert!(end.cmple(UVec2::from(view.size)).all() && region.origin % TILE == UVec2::ZERO, "{region:?}");
            partial += u32::from(region.size != UVec2::from(view.size));
            for i in 0..200 {
                let bounds = volumes[i % 2].bounds();
                let at = Vec3::new(random(), random(), random()).map(|t| (1.2 * t - 0.1).clamp(0.0, 1.0));
                let point = bounds.min + at * bounds.size();
                if let Some(pixel) = pixel(&view, point) {
                    shown += 1;
                    let is_relit = pixel.cmpge(region.origin).all() && pixel.cmplt(end).all();
                    assert!(is_relit, "{point} is at {pixel}, beyond {region:?}");
                }
            }
        }
        assert!(partial > 50 && shown > 5000, "{partial} views, {shown} points");
    }
}
