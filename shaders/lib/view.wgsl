#define_import_path lightwell::view

// The view that a frame is drawn from.
struct View {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    // Where lines of sight come from, in homogeneous coordinates: the eye [m] with w = 1, or where they are parallel the
    // unit vector towards it with w = 0.
    eye: vec4f,
    axis: vec4f,           // the plane from which distances along the view's axis are measured [m]
    size: vec2u,           // [pixels]
    pixel: f32,            // width of a pixel at a depth of 1 m, or where lines of sight are parallel at any [m]
    reach: f32,            // distance from the eye to the farthest corner of the scene's bounds, at most twice that [m]
}

// From a point towards the eye; not of unit length. In a perspective it reaches as far as the eye.
fn toward_eye(view: View, position: vec3f) -> vec3f {
    return view.eye.xyz - position * view.eye.w;
}

// Distance along the view's axis [m].
fn view_depth(view: View, position: vec3f) -> f32 {
    return view.axis.x * position.x + view.axis.y * position.y + view.axis.z * position.z + view.axis.w;
}

// Distance of a visible point: from the eye, or along parallel lines of sight [m].
fn eye_distance(view: View, position: vec3f) -> f32 {
    return select(view_depth(view, position), distance(position, view.eye.xyz), view.eye.w > 0.0);
}

// What rounding of a position is relative to, beside its coordinates [m]: in a perspective the distance from the eye. With
// parallel lines of sight depth is linear, and as coarse everywhere as at the far plane; 2⁻²⁴ of that range counts here
// as much as 2⁻¹⁷ of a distance.
fn depth_error(view: View, position: vec3f) -> f32 {
    let row = vec3f(view.clip_from_world[0].z, view.clip_from_world[1].z, view.clip_from_world[2].z);
    let range = inverseSqrt(max(dot(row, row), 1e-36));
    return select(max(view_depth(view, position), 0.0078125 * range), distance(position, view.eye.xyz), view.eye.w > 0.0);
}

// Width of a pixel at a visible point, across the view [m].
fn pixel_width(view: View, position: vec3f) -> f32 {
    return view.pixel * select(1.0, view_depth(view, position), view.eye.w > 0.0);
}

// What a visible point may be off its surface [m]: what rounding of its coordinates and of depth moves it by, and what its
// triangle's corners were moved by. Rasterizers put those on a grid of 1/256 of a pixel (Vulkan 1.3, subPixelPrecisionBits),
// and depths follow them: the point is then off by at most 1/512 of a pixel in x and in y. Software drivers interpolate
// depth between the corners as they were. A triangle that is clipped is moved by the rounding of its farthest corners, which is
// what counts in worlds of kilometres. Rays start four times as far off.
fn position_error(view: View, position: vec3f) -> f32 {
    let p = abs(position);
    let largest = max(max(p.x, p.y), max(p.z, depth_error(view, position)));
    return max(largest * 0x1p-17f + pixel_width(view, position) * 0x1p-10f, view.reach * 0x1p-24f);
}

// Whether a stored depth is behind another one by more than a part of the distance, or where lines of sight are parallel
// by more than that part of the image's height.
fn is_behind(view: View, depth: f32, surface: f32, part: f32) -> bool {
    let c = view.clip_from_world;
    let along = vec3f(c[0].z, c[1].z, c[2].z);
    let upwards = vec3f(c[0].y, c[1].y, c[2].y);
    let height = 2.0 * length(along) * inverseSqrt(max(dot(upwards, upwards), 1e-36));
    return depth < select(surface - part * height, surface * (1.0 - part), view.eye.w > 0.0);
}
