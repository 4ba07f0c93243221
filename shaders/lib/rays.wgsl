#define_import_path lightwell::rays

// Rays, and where they meet a triangle. On their way there they are followed by lib/walk.wgsl.

#ifdef GLASS
#import lightwell::glass::{NOTHING_TAKEN, Taken, glass_at, pass_share, taken_at}
#endif
#import lightwell::mesh::BLENDED
#import lightwell::ray_materials::base_color_at
#import lightwell::ray_scene::{ALPHA_TESTED, CASTS_SHADOW, DOUBLE_SIDED, NONE, load_triangle, materials}
#ifdef GLASS
#import lightwell::ray_scene::OF_GLASS
#endif
#import lightwell::ray_textures::coordinates
#import lightwell::sampling::hash_pair

// What a ray is for.
const CAMERA: u32 = 0u;    // nearest surface, backs of single-sided ones left out
const LIGHT: u32 = 1u;     // nearest surface that casts shadows, from both sides
const SHADOW: u32 = 2u;    // any surface that casts shadows; which one is not said
// Light passes glass straight: LIGHT rays go through, and SHADOW rays count what it takes. With GLASS_REFLECTS a LIGHT ray meets
// it by chance, as often as it does not let pass. Two kinds more:
const SEEN: u32 = 3u;      // nearest surface that casts shadows or is of glass, from both sides
const THROUGH: u32 = 4u;   // none: what glass takes up to a distance
const PANE: u32 = 5u;      // nearest surface of glass, backs of single-sided ones left out

struct Ray {
    origin: vec3f,
    direction: vec3f,      // of any length; distances are in its units
}

struct Hit {
    t: f32,
    triangle: u32,         // NONE: nothing was met
    barycentric: vec2f,    // of the second and third corner
#ifdef GLASS
    taken: Taken,          // by glass on the way of a SHADOW or THROUGH ray
#endif
}

fn hit_of(t: f32, triangle: u32, barycentric: vec2f) -> Hit {
#ifdef GLASS
    return Hit(t, triangle, barycentric, NOTHING_TAKEN);
#else
    return Hit(t, triangle, barycentric);
#endif
}

fn no_hit(reach: f32) -> Hit {
    return hit_of(reach, NONE, vec2f(0.0));
}

fn inverse_direction(d: vec3f) -> vec3f {
    // No component is zero, so that no 0·∞ arises.
    return select(select(vec3f(1e20), vec3f(-1e20), d < vec3f(0.0)), 1.0 / d, abs(d) > vec3f(1e-20));
}

// Signs of a direction: bit i says that it is negative on axis i.
fn octant(direction: vec3f) -> u32 {
    let negative = vec3u(direction < vec3f(0.0));
    return negative.x + 2u * negative.y + 4u * negative.z;
}

// A number in [0, 1) for a ray and a point of a triangle: of all rays through a blended surface the share 1 − alpha
// passes (stochastic transparency, Enderton et al. 2010), which is the mean that blending computes. Triangles are told
// apart by the point: their numbers follow the hierarchy, which depends on the frames before.
fn pass_chance(ray: Ray, barycentric: vec2f) -> f32 {
    let o = bitcast<vec3u>(ray.origin);
    let d = bitcast<vec3u>(ray.direction);
    let a = hash_pair(o.x ^ (o.y * 0x9e3779b9u), o.z ^ (d.x * 0x85ebca6bu));
    let at = bitcast<vec2u>(barycentric);
    let b = hash_pair(d.y ^ (d.z * 0xc2b2ae35u), hash_pair(at.x, at.y));
    return f32((hash_pair(a, b)) >> 8u) * 0x1p-24f;
}

// Whether a ray passes a point of that alpha.
fn is_transparent(alpha: f32, cutoff: f32, barycentric: vec2f, ray: Ray) -> bool {
    if cutoff >= BLENDED {
        return alpha <= pass_chance(ray, barycentric);
    }
    return alpha < cutoff;
}

// Möller and Trumbore 1997, without any tolerance: the hit so far, or a nearer one with this triangle, whatever its alpha and its
// glass let pass. Of one that is known to be opaque no glass is looked for; callers give a constant.
fn candidate(index: u32, ray: Ray, hit: Hit, kind: u32, is_opaque: bool) -> Hit {
    let triangle = load_triangle(index);
    let edge_b = triangle.corner_b - triangle.corner_a;
    let edge_c = triangle.corner_c - triangle.corner_a;
    let p = cross(ray.direction, edge_c);
    let determinant = dot(edge_b, p);
    let r = 1.0 / determinant;
    let s = ray.origin - triangle.corner_a;
    let u = dot(s, p) * r;
    let q = cross(s, edge_b);
    let v = dot(ray.direction, q) * r;
    let t = dot(edge_c, q) * r;
    // Seen from the front the determinant is positive.
    let is_shown = determinant > 0.0 || (triangle.flags & DOUBLE_SIDED) != 0u;
    var counts = select((triangle.flags & CASTS_SHADOW) != 0u, is_shown, kind == CAMERA);
#ifdef GLASS
    let is_glass = !is_opaque && (triangle.flags & OF_GLASS) != 0u;
    counts = (counts || (kind == SEEN && is_glass)) && (kind != THROUGH || is_glass);
    counts = select(counts, is_shown && is_glass, kind == PANE);
#ifndef GLASS_REFLECTS
    counts = counts && !(kind == LIGHT && is_glass);
#endif
#endif
    // Where two triangles are met at the same distance, the point on them says which counts: their order depends on the
    // frames before, and on which of them moves.
    let is_tie_won = t == hit.t && hit.triangle != NONE
        && (u < hit.barycentric.x || (u == hit.barycentric.x && v < hit.barycentric.y));
    let met = counts && determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
        && (t < hit.t || is_tie_won);
    if !met {
        return hit;
    }
#ifdef GLASS
    return Hit(t, index, vec2f(u, v), hit.taken);
#else
    return Hit(t, index, vec2f(u, v));
#endif
}

// A candidate, if the ray ends there, or the hit before it, with what glass has taken there.
fn accepted(met: Hit, before: Hit, ray: Ray, kind: u32) -> Hit {
    let triangle = load_triangle(met.triangle);
    let material = triangle.material;
    let place = coordinates(met.triangle, met.barycentric);
    let base = base_color_at(material, place);
#ifndef OPAQUE
    let is_tested = (triangle.flags & ALPHA_TESTED) != 0u;
    if is_tested && is_transparent(base.a, materials[material].alpha_cutoff, met.barycentric, ray) {
        return before;
    }
#endif
#ifdef GLASS
    if (triangle.flags & OF_GLASS) != 0u && kind != CAMERA && kind != SEEN && kind != PANE {
        let edge_b = triangle.corner_b - triangle.corner_a;
        let edge_c = triangle.corner_c - triangle.corner_a;
        let determinant = dot(edge_b, cross(ray.direction, edge_c));
        let cosine = abs(determinant) / max(length(cross(edge_b, edge_c)) * length(ray.direction), 1e-30);
        let glass = glass_at(material, place, base.rgb);
#ifdef GLASS_REFLECTS
        if kind == LIGHT {
            if pass_share(glass, cosine) > pass_chance(ray, met.barycentric) {
                return before;
            }
            return met;
        }
#endif
        var through = before;
        let distance = met.t * length(ray.direction);
        through.taken = taken_at(before.taken, glass, cosine, distance, determinant > 0.0, kind == THROUGH);
        return through;
    }
#endif
    return met;
}

// The hit so far, or a nearer one with this triangle. Of one that is known to be opaque neither alpha nor glass is looked at;
// callers give a constant.
fn meet_triangle(index: u32, ray: Ray, hit: Hit, kind: u32, is_opaque: bool) -> Hit {
    let met = candidate(index, ray, hit, kind, is_opaque);
#ifdef CLASSES
    return met;
#else
    if is_opaque || met.triangle == hit.triangle {
        return met;
    }
    return accepted(met, hit, ray, kind);
#endif
}
