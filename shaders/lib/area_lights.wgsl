#define_import_path lightwell::area_lights

// Lights with a surface: spheres, discs, rectangles and tubes of even radiance, and the sun as a disc of the sky. They are
// sampled at points of that surface, and met by rays.
//
// What a sample brings is I·cosθ/d² and the like, for which no area is divided by: a light that shrinks becomes a point light,
// and one without any area is one. 1/density is kept instead of the density, for the same reason.

#import lightwell::lights::{Light, Incidence, SUN, SPHERE, DISC, RECTANGLE, TUBE, MAX_IRRADIANCE, light_incidence, range_window}
#import lightwell::sampling::{TAU, basis}

const PI: f32 = 3.14159265358979;
// How far off the sun is for rays.
const FAR: f32 = 3e38;

fn is_area(light: Light) -> bool {
    return light.shape >= SUN;
}

fn no_incidence() -> Incidence {
    return Incidence(vec3f(0.0, 1.0, 0.0), 0.0, vec3f(0.0), 0.0);
}

// The third axis of a rectangle, a disc or a tube: a right angle to `direction` and `axis`.
fn third_axis(light: Light) -> vec3f {
    return cross(light.direction, light.axis);
}

// ---- Spheres and the sun: cones of directions ----

struct Cone {
    axis: vec3f,           // unit, to the middle
    sine: f32,             // of the half angle
    cosine: f32,
    irradiance: vec3f,     // on a plane across the axis [W/m²]
}

// The cone in which a sphere or the sun is seen; without irradiance inside the sphere, whose light goes outwards.
fn cone_of(light: Light, position: vec3f) -> Cone {
    if light.shape == SUN {
        return Cone(-light.direction, light.size.x, light.size.y, light.intensity);
    }
    let offset = light.position - position;
    let distance = length(offset);
    if distance <= light.size.x || distance <= 1e-18 {
        return Cone(vec3f(0.0, 1.0, 0.0), 0.0, 1.0, vec3f(0.0));
    }
    let sine = light.size.x / distance;
    let cosine = sqrt(max(0.0, 1.0 - sine * sine));
    let intensity = light.intensity * range_window(light, distance);
    let irradiance = min(intensity / distance, vec3f(MAX_IRRADIANCE)) / distance;
    return Cone(offset / distance, sine, cosine, irradiance);
}

// Solid angle of the cone [sr]: 2π·(1 − cos), without a difference of nearly equal numbers.
fn solid_angle_of(cone: Cone) -> f32 {
    return TAU * cone.sine * cone.sine / (1.0 + cone.cosine);
}

// E on a plane across the axis is L·π·sin². Over the density of an even choice from the cone that is 2·E/(1 + cos).
fn incidence_in_cone(light: Light, cone: Cone, position: vec3f, direction: vec3f) -> Incidence {
    let irradiance = min(cone.irradiance * (2.0 / (1.0 + cone.cosine)), vec3f(MAX_IRRADIANCE));
    var distance = 0.0;
    if light.shape != SUN {
        // The nearer end of the chord: (o·d) − √(r² − |o × d|²).
        let offset = light.position - position;
        let off_axis = cross(offset, direction);
        let half_chord = sqrt(max(0.0, light.size.x * light.size.x - dot(off_axis, off_axis)));
        distance = max(dot(offset, direction) - half_chord, 0.0);
    }
    return Incidence(direction, distance, irradiance, solid_angle_of(cone));
}

fn sample_cone(light: Light, position: vec3f, random: vec2f) -> Incidence {
    let cone = cone_of(light, position);
    if all(cone.irradiance <= vec3f(0.0)) {
        return no_incidence();
    }
    // 1 − cos of the angle to the axis, even in solid angle.
    let fall = random.x * cone.sine * cone.sine / (1.0 + cone.cosine);
    let sine = sqrt(max(0.0, fall * (2.0 - fall)));
    let angle = TAU * random.y;
    let local = vec3f(sine * cos(angle), sine * sin(angle), 1.0 - fall);
    return incidence_in_cone(light, cone, position, normalize(basis(cone.axis) * local));
}

fn meet_cone(light: Light, position: vec3f, direction: vec3f) -> Incidence {
    let cone = cone_of(light, position);
    // By the sine where the cosine is hardly below one.
    let off_axis = cross(cone.axis, direction);
    let is_within = dot(cone.axis, direction) > 0.0
        && select(dot(off_axis, off_axis) <= cone.sine * cone.sine, dot(cone.axis, direction) >= cone.cosine, cone.cosine < 0.5);
    if !is_within || all(cone.irradiance <= vec3f(0.0)) {
        return no_incidence();
    }
    return incidence_in_cone(light, cone, position, direction);
}

// ---- Discs, rectangles and tubes: points of a surface ----

// Part of a surface that a point is chosen from, evenly.
struct Patch {
    area: f32,             // [m²]
    to_irradiance: f32,    // L·area over I
}

// Light from a point of the light with that unit normal: E = I·cosθ/d² for a flat light, whose I is L·A.
fn incidence_of_point(light: Light, position: vec3f, place: vec3f, n: vec3f, part: Patch) -> Incidence {
    let offset = place - position;
    let distance = max(length(offset), 1e-18);
    let to_light = offset / distance;
    let cosine = -dot(n, to_light);
    if cosine <= 0.0 {
        return no_incidence();
    }
    let window = range_window(light, length(light.position - position));
    let intensity = light.intensity * (window * cosine * part.to_irradiance);
    let irradiance = min(min(intensity / distance, vec3f(MAX_IRRADIANCE)) / distance, vec3f(MAX_IRRADIANCE));
    return Incidence(to_light, distance, irradiance, part.area / distance * (cosine / distance));
}

fn flat_area(light: Light) -> f32 {
    return select(4.0 * light.size.x * light.size.y, PI * light.size.x * light.size.x, light.shape == DISC);
}

fn sample_flat(light: Light, position: vec3f, random: vec2f) -> Incidence {
    var at = (2.0 * random - 1.0) * light.size;
    if light.shape == DISC {
        let angle = TAU * random.y;
        at = light.size.x * sqrt(random.x) * vec2f(cos(angle), sin(angle));
    }
    let place = light.position + at.x * light.axis + at.y * third_axis(light);
    return incidence_of_point(light, position, place, light.direction, Patch(flat_area(light), 1.0));
}

fn meet_flat(light: Light, position: vec3f, direction: vec3f) -> Incidence {
    let toward = -dot(light.direction, direction);
    let offset = light.position - position;
    let height = -dot(light.direction, offset);
    // On the side that it does not shine to, or along its plane.
    if toward <= 0.0 || height <= 0.0 {
        return no_incidence();
    }
    let place = position + direction * (height / toward);
    let across = place - light.position;
    let at = vec2f(dot(across, light.axis), dot(across, third_axis(light)));
    let is_within = select(all(abs(at) <= light.size), dot(at, at) <= light.size.x * light.size.x, light.shape == DISC);
    if !is_within {
        return no_incidence();
    }
    return incidence_of_point(light, position, place, light.direction, Patch(flat_area(light), 1.0));
}

// What a point sees of a tube, which is the same arc all along it.
struct Arc {
    toward: vec3f,         // unit, from the axis to the point
    across: vec3f,         // unit, at right angles to that and to the axis
    half_angle: f32,       // 0: nothing
}

fn arc_of(light: Light, position: vec3f) -> Arc {
    let offset = position - light.position;
    let from_axis = offset - light.axis * dot(offset, light.axis);
    let distance = length(from_axis);
    if distance <= light.size.y || distance <= 1e-18 {
        return Arc(light.direction, third_axis(light), 0.0);
    }
    let toward = from_axis / distance;
    return Arc(toward, cross(light.axis, toward), acos(light.size.y / distance));
}

// L is I over the tube's profile, length times 2·radius, and the arc's surface is length times 2·half_angle·radius.
fn tube_patch(light: Light, arc: Arc) -> Patch {
    return Patch(4.0 * light.size.x * light.size.y * arc.half_angle, arc.half_angle);
}

fn sample_tube(light: Light, position: vec3f, random: vec2f) -> Incidence {
    let arc = arc_of(light, position);
    if arc.half_angle <= 0.0 {
        return no_incidence();
    }
    let angle = (2.0 * random.y - 1.0) * arc.half_angle;
    let n = cos(angle) * arc.toward + sin(angle) * arc.across;
    let place = light.position + light.axis * ((2.0 * random.x - 1.0) * light.size.x) + n * light.size.y;
    return incidence_of_point(light, position, place, n, tube_patch(light, arc));
}

fn meet_tube(light: Light, position: vec3f, direction: vec3f) -> Incidence {
    let arc = arc_of(light, position);
    let offset = position - light.position;
    let o = offset - light.axis * dot(offset, light.axis);
    let d = direction - light.axis * dot(direction, light.axis);
    let a = dot(d, d);
    let b = dot(o, d);
    let off_axis = cross(o, d);
    let discriminant = a * light.size.y * light.size.y - dot(off_axis, off_axis);
    if arc.half_angle <= 0.0 || a <= 1e-20 || discriminant < 0.0 || b >= 0.0 {
        return no_incidence();
    }
    let place = position + direction * ((-b - sqrt(discriminant)) / a);
    let along = dot(place - light.position, light.axis);
    if abs(along) > light.size.x {
        return no_incidence();
    }
    let n = (place - light.position - light.axis * along) / max(light.size.y, 1e-30);
    return incidence_of_point(light, position, place, n, tube_patch(light, arc));
}

// ---- All of them ----

// Light of one point of a light, chosen by two random numbers: its mean over them is the light's. Lights without a surface
// have but one.
fn sample_incidence(light: Light, position: vec3f, random: vec2f) -> Incidence {
    switch light.shape {
        case SUN, SPHERE: { return sample_cone(light, position, random); }
        case DISC, RECTANGLE: { return sample_flat(light, position, random); }
        case TUBE: { return sample_tube(light, position, random); }
        default: { return light_incidence(light, position); }
    }
}

// The same of the point that a ray of unit direction meets, without irradiance where it meets none: what `sample_incidence`
// would bring from there.
fn meet_light(light: Light, position: vec3f, direction: vec3f) -> Incidence {
    switch light.shape {
        case SUN, SPHERE: { return meet_cone(light, position, direction); }
        case DISC, RECTANGLE: { return meet_flat(light, position, direction); }
        case TUBE: { return meet_tube(light, position, direction); }
        default: { return no_incidence(); }
    }
}
