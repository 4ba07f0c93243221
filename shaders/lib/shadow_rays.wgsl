#define_import_path lightwell::shadow_rays

// Shadow rays from what the camera sees.

#import lightwell::lights::Incidence
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::{Surface as Start, leave_surface}
#import lightwell::rays::{SHADOW, Ray}
#ifdef GLASS
#import lightwell::rays::THROUGH
#import lightwell::walk::comes_by_glass
#endif
#import lightwell::walk::{left_by_glass, passed, trace}
#import lightwell::view::{View, position_error}

// The way from a visible point to the light.
struct Way {
    ray: Ray,
    reach: f32,
}

fn way_to(view: View, position: vec3f, n: vec3f, incidence: Incidence) -> Way {
    var start: Start;
    start.position = position;
    start.geometric_normal = n;
    start.error = position_error(view, position);
    let origin = leave_surface(start, incidence.to_light);
    // To the light itself, whose distance is not that of the moved origin; directional light comes from far.
    let is_far = incidence.distance == 0.0;
    let offset = position + incidence.to_light * incidence.distance - origin;
    // The surface of a light may lie on one of the scene.
    let reach = select(1.0, 0.9999, incidence.solid_angle > 0.0);
    return Way(Ray(origin, select(offset, incidence.to_light, is_far)), select(reach, 3e38, is_far));
}

// What of the light arrives at a visible point: all, nothing, or what glass leaves of it.
fn arriving(view: View, root: u32, position: vec3f, n: vec3f, incidence: Incidence) -> vec3f {
    let way = way_to(view, position, n, incidence);
    let hit = trace(root, way.ray, way.reach, SHADOW);
    return select(vec3f(0.0), passed(way.ray, hit), hit.triangle == NONE);
}

// What glass leaves of light for which nothing else is in the way.
fn left_on_way(view: View, root: u32, position: vec3f, n: vec3f, incidence: Incidence) -> vec3f {
    let way = way_to(view, position, n, incidence);
    return left_by_glass(root, way.ray, way.reach);
}

// A share of light that is passed by all but glass, which is not known.
const UNKNOWN: f32 = -1.0;

// What of the light arrives at a visible point, of which all but glass lets pass a share: where that is not known, the ray that
// counts the glass tells it as well.
fn passing_on_way(view: View, root: u32, position: vec3f, n: vec3f, incidence: Incidence, share: f32) -> vec3f {
    let way = way_to(view, position, n, incidence);
    let is_unknown = share == UNKNOWN;
#ifdef GLASS
    let is_asked = is_unknown || (share > 0.0 && comes_by_glass(way.ray, way.reach));
    let kind = select(THROUGH, SHADOW, is_unknown);
#else
    let is_asked = is_unknown;
    let kind = SHADOW;
#endif
    if !is_asked {
        return vec3f(share);
    }
    let hit = trace(root, way.ray, way.reach, kind);
    let is_blocked = is_unknown && hit.triangle != NONE;
    return select(passed(way.ray, hit) * select(share, 1.0, is_unknown), vec3f(0.0), is_blocked);
}
