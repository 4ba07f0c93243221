// Light-emitting particles: a disc for each that faces the eye, that hides most in the middle, over what lies behind. A disc
// of radius R that hides (1 − q²)² of it, q from its middle to its border, and shines as much with radiance L, has the radiant
// intensity L·πR²/3: that of a sphere of radius R/√3.
//   HAZE  media are in the way

#import lightwell::gbuffer::world_position
#ifdef HAZE
#import lightwell::haze_lookup::veil
#endif
#import lightwell::view::{View, eye_distance, pixel_width, toward_eye, view_depth}

struct Ball {
    position: vec3f,       // world [m]
    radius: f32,           // [m]; 0: there is none
    radiance: vec3f,       // [W/(m² sr)]
    age: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> balls: array<Ball>;
@group(0) @binding(2) var depth: texture_depth_2d;

struct Disc {
    @builtin(position) position: vec4f,
    // From the middle, where the border is at 1.
    @location(0) place: vec2f,
    @location(1) @interpolate(flat) radiance: vec3f,
    // Share of what lies behind that its middle hides.
    @location(4) @interpolate(flat) cover: f32,
    @location(2) @interpolate(flat) middle: vec3f, // world [m]
    @location(3) @interpolate(flat) radius: f32,   // of the disc [m]
}

const ROOT_OF_THREE: f32 = 1.7320508;
// Least radius of a disc [pixels]: as much light as it has falls on the pixels around it, wherever their middles are.
const LEAST_RADIUS: f32 = 1.5;
const MAX_RADIANCE: f32 = 1e32;

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Disc {
    let ball = balls[index];
    var disc: Disc;
    // Outside of the image: nothing is drawn.
    disc.position = vec4f(2.0, 2.0, 2.0, 1.0);
    if !(ball.radius > 0.0) || (view.eye.w > 0.0 && view_depth(view, ball.position) <= 0.0) {
        return disc;
    }
    let true_radius = ROOT_OF_THREE * ball.radius;
    disc.radius = max(true_radius, LEAST_RADIUS * pixel_width(view, ball.position));
    let dimmed = true_radius / disc.radius;
    disc.radiance = ball.radiance;
    disc.cover = dimmed * dimmed;
    disc.middle = ball.position;
    // Two triangles: corners 0, 1, 2 and 2, 1, 3 of a square.
    let number = array(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    disc.place = vec2f(f32(number & 1u), f32(number >> 1u)) * 2.0 - 1.0;
    let to_eye = normalize(toward_eye(view, ball.position));
    let aside = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(to_eye.y) > 0.9);
    let right = normalize(cross(aside, to_eye));
    let up = cross(to_eye, right);
    let at = ball.position + (right * disc.place.x + up * disc.place.y) * disc.radius;
    disc.position = view.clip_from_world * vec4f(at, 1.0);
    return disc;
}

@fragment
fn fragment(disc: Disc) -> @location(0) vec4f {
    let q = dot(disc.place, disc.place);
    if q >= 1.0 {
        discard;
    }
    var cover = disc.cover * ((1.0 - q) * (1.0 - q));
    let pixel = vec2u(disc.position.xy);
    let z = textureLoad(depth, pixel, 0);
    if z > 0.0 {
        // A surface through its middle hides half of it.
        let before = eye_distance(view, world_position(pixel, view.size, z, view.world_from_clip)) - eye_distance(view, disc.middle);
        cover *= saturate(0.5 + 0.5 * before / disc.radius);
    }
    var light = disc.radiance;
#ifdef HAZE
    light *= veil(view, disc.position.xy, disc.middle, false).passing;
#endif
    return vec4f(min(light * cover, vec3f(MAX_RADIANCE)), cover);
}
