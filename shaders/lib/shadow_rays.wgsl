#define_import_path lightwell::shadow_rays

// Shadow rays from what the camera sees.

#import lightwell::lights::Incidence
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::{Surface as Start, leave_surface}
#import lightwell::rays::{SHADOW, Ray, trace}
#import lightwell::view::{View, toward_eye}

// Whether nothing is between a visible point and the light.
fn is_reached(view: View, root: u32, position: vec3f, n: vec3f, incidence: Incidence) -> bool {
    var start: Start;
    start.position = position;
    start.geometric_normal = n;
    // What the depth buffer's rounding may have moved the point by; a ray starts four times as far off.
    let p = max(abs(position), abs(toward_eye(view, position)));
    start.error = max(p.x, max(p.y, p.z)) * 0x1p-17f;
    let origin = leave_surface(start, incidence.to_light);
    // To the light itself, whose distance is not that of the moved origin; directional light comes from far.
    let is_far = incidence.distance == 0.0;
    let offset = position + incidence.to_light * incidence.distance - origin;
    let ray = Ray(origin, select(offset, incidence.to_light, is_far));
    // The surface of a light may lie on one of the scene.
    let reach = select(1.0, 0.9999, incidence.solid_angle > 0.0);
    return trace(root, ray, select(reach, 3e38, is_far), SHADOW).triangle == NONE;
}
