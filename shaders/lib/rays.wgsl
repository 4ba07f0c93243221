#define_import_path lightwell::rays

// Rays through the scene: which triangle one meets.

#ifdef GLASS
#import lightwell::glass::{NOTHING_TAKEN, Taken, glass_at, left_of, pass_share, taken_at}
#endif
#import lightwell::mesh::BLENDED
#import lightwell::ray_materials::alpha_at
#import lightwell::ray_scene::{ALPHA_TESTED, CASTS_SHADOW, COUNT_BITS, DOUBLE_SIDED, FIRST_MASK, LEAF, NONE, box_texel, load_triangle, materials, nodes}
#ifdef GLASS
#import lightwell::ray_scene::{OF_GLASS, glass_box}
#endif
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

// Where the boxes lie.
struct Frame {
    origin: vec3f,
    unit: vec3f,
    boxes: u32,            // of a list
    movers: u32,           // where those of dynamic objects begin; 0: nothing does
}

// `boxes` is the number of boxes of a list of static objects, which the host knows.
fn load_frame(boxes: u32) -> Frame {
    let second = textureLoad(nodes, vec2u(1u, 0u));
#ifdef EXACT_BOXES
    return Frame(vec3f(0.0), vec3f(1.0), boxes, second.w);
#else
    let origin = bitcast<vec3f>(textureLoad(nodes, vec2u(0u, 0u)).xyz);
    return Frame(origin, bitcast<vec3f>(second.xyz), boxes, second.w);
#endif
}

// A ray on its way along its list of boxes, which lie at box·scale + offset along it.
struct Walk {
    ray: Ray,
    scale: vec3f,
    offset: vec3f,
    next: u32,             // box to be looked at
    end: u32,              // of the list
#ifdef MOVERS
    movers: u32,           // where those of dynamic objects begin, if they are still to be looked at; else 0
#endif
    kind: u32,
    hit: Hit,              // so far
}

struct Box {
    low: vec3f,
    high: vec3f,
    link: u32,
}

// A ray at its start; one without reach is over already.
fn begin_walk(frame: Frame, ray: Ray, reach: f32, kind: u32) -> Walk {
    let inverse = inverse_direction(ray.direction);
    let first = HEADER + octant(ray.direction) * frame.boxes;
    let end = first + frame.boxes;
    let next = select(end, first, reach > 0.0);
    let hit = no_hit(reach);
#ifdef EXACT_BOXES
    let scale = inverse;
    let offset = ray.origin;
#else
    let scale = frame.unit * inverse;
    let offset = (frame.origin - ray.origin) * inverse;
#endif
#ifdef MOVERS
    return Walk(ray, scale, offset, next, end, frame.movers, kind, hit);
#else
    return Walk(ray, scale, offset, next, end, kind, hit);
#endif
}

// Which of the eight lists is that of a direction.
fn octant(direction: vec3f) -> u32 {
    let negative = vec3u(direction < vec3f(0.0));
    return negative.x + 2u * negative.y + 4u * negative.z;
}

#ifdef MOVERS
// Among moving objects' boxes: none, but a link that is always followed.
#ifdef EXACT_BOXES
const JUMP: f32 = 0x1.fffffep+127f;
#else
const JUMP: f32 = 65535.0;
#endif
// The link that ends all of their lists.
const NOWHERE: u32 = LEAF - 1u;

// The list over moving objects, after that of static objects: it leads into lists of each object, and back (see
// rays/moving_boxes.rs).
fn go_on_with_movers(walk: ptr<function, Walk>) {
    let place = (*walk).movers;
#ifdef EXACT_BOXES
    let boxes = textureLoad(nodes, box_texel(2u * place)).w;
#else
    let header = textureLoad(nodes, box_texel(place));
    let boxes = header.w;
    let unit = bitcast<vec3f>(textureLoad(nodes, box_texel(place + 1u)).xyz);
    let inverse = inverse_direction((*walk).ray.direction);
    (*walk).scale = unit * inverse;
    (*walk).offset = (bitcast<vec3f>(header.xyz) - (*walk).ray.origin) * inverse;
#endif
    (*walk).next = place + HEADER + octant((*walk).ray.direction) * boxes;
    (*walk).end = NOWHERE;
    (*walk).movers = 0u;
}
#endif

// Boxes that the two texels before the lists take.
#ifdef EXACT_BOXES
const HEADER: u32 = 1u;
#else
const HEADER: u32 = 2u;
#endif

fn load_box(index: u32) -> Box {
#ifdef EXACT_BOXES
    let low = textureLoad(nodes, box_texel(2u * index));
    let high = textureLoad(nodes, box_texel(2u * index + 1u));
    return Box(bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz), low.w);
#else
    let words = textureLoad(nodes, box_texel(index));
    // Signed, since that is one instruction on adapters that convert unsigned numbers in six.
    let low = vec3i(vec3u(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu));
    let high = vec3i(vec3u(words.y >> 16u, words.z & 0xffffu, words.z >> 16u));
    return Box(vec3f(low), vec3f(high), words.w);
#endif
}

// Whether the ray meets the box before t_max.
//
// Floats that are not negative are ordered as their bits are, and what is negative stays so: whole numbers will do,
// whose minimum is one instruction where that of floats has to look out for NaN.
fn meets_box(box: Box, walk: Walk) -> bool {
#ifdef EXACT_BOXES
    let a = bitcast<vec3i>((box.low - walk.offset) * walk.scale);
    let b = bitcast<vec3i>((box.high - walk.offset) * walk.scale);
#else
    let a = bitcast<vec3i>(box.low * walk.scale + walk.offset);
    let b = bitcast<vec3i>(box.high * walk.scale + walk.offset);
#endif
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0));
    let leave = min(min(far.x, far.y), min(far.z, bitcast<i32>(walk.hit.t)));
    // Four roundings further, so that no box is missed that holds a hit (Ize 2013).
#ifdef MOVERS
    return enter <= leave + 4 && box.low.x < JUMP;
#else
    return enter <= leave + 4;
#endif
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

fn is_transparent(triangle: u32, material: u32, barycentric: vec2f, ray: Ray) -> bool {
    let alpha = alpha_at(triangle, material, barycentric);
    let cutoff = materials[material].alpha_cutoff;
    if cutoff >= BLENDED {
        return alpha <= pass_chance(ray, barycentric);
    }
    return alpha < cutoff;
}

// Möller and Trumbore 1997, without any tolerance: the hit so far, or a nearer one with this triangle.
fn meet_triangle(index: u32, ray: Ray, hit: Hit, kind: u32) -> Hit {
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
    let is_glass = (triangle.flags & OF_GLASS) != 0u;
    counts = (counts || (kind == SEEN && is_glass)) && (kind != THROUGH || is_glass);
    counts = select(counts, is_shown && is_glass, kind == PANE);
#endif
    // Where two triangles are met at the same distance, the point on them says which counts: their order depends on the
    // frames before, and on which of them moves.
    let is_tie_won = t == hit.t && hit.triangle != NONE
        && (u < hit.barycentric.x || (u == hit.barycentric.x && v < hit.barycentric.y));
    var met = counts && determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
        && (t < hit.t || is_tie_won);
#ifndef OPAQUE
    if met && (triangle.flags & ALPHA_TESTED) != 0u {
        met = !is_transparent(index, triangle.material, vec2f(u, v), ray);
    }
#endif
#ifdef GLASS
    if met && is_glass && kind != CAMERA && kind != SEEN && kind != PANE {
        let cosine = abs(determinant) / max(length(cross(edge_b, edge_c)) * length(ray.direction), 1e-30);
        let glass = glass_at(index, triangle.material, vec2f(u, v));
#ifdef GLASS_REFLECTS
        if kind == LIGHT {
            met = pass_share(glass, cosine) <= pass_chance(ray, vec2f(u, v));
        }
#endif
        if kind != LIGHT {
            var through = hit;
            through.taken = taken_at(hit.taken, glass, cosine, t * length(ray.direction), determinant > 0.0, kind == THROUGH);
            return through;
        }
#ifndef GLASS_REFLECTS
        met = false;
#endif
    }
    if met {
        return Hit(t, index, vec2f(u, v), hit.taken);
    }
#else
    if met {
        return Hit(t, index, vec2f(u, v));
    }
#endif
    return hit;
}

fn is_over(walk: Walk) -> bool {
    return walk.next >= walk.end;
}

// Looks at boxes until there are two leaves or more, or nothing is left, and then into the leaves: adapters that run
// lanes in lockstep let no lane look into one while others search (Aila and Laine 2009, "Understanding the efficiency
// of ray traversal on GPUs"). The walk must not be over.
fn go_on(walk: ptr<function, Walk>) {
    // Leaves whose boxes are met: one of earlier boxes, and those of the last two boxes.
    var leaf = 0u;
    var box_leaf = 0u;
    var after_leaf = 0u;
    loop {
        // The box behind is the next one of most rays, and both at once take not much longer than one: most of the
        // time goes into waiting, for memory and for one result after another. What lies behind the list's end leads
        // nowhere or is met in vain.
        let box = load_box((*walk).next);
        let after = load_box((*walk).next + 1u);
        let is_leaf = box.link >= LEAF;
        let is_after_leaf = after.link >= LEAF;
        let is_met = meets_box(box, *walk);
        let is_after_met = meets_box(after, *walk);
        let reaches_after = is_met || is_leaf;
        leaf |= box_leaf | after_leaf;
        box_leaf = select(0u, box.link, is_met && is_leaf);
        after_leaf = select(0u, after.link, reaches_after && is_after_met && is_after_leaf);
        let after_next = select(after.link, (*walk).next + 2u, is_after_met || is_after_leaf);
        (*walk).next = select(box.link, after_next, reaches_after);
        continuing {
            let leaves = u32(leaf != 0u) + u32(box_leaf != 0u) + u32(after_leaf != 0u);
            break if leaves >= 2u || (*walk).next >= (*walk).end;
        }
    }
    while (leaf | box_leaf | after_leaf) != 0u {
        if leaf == 0u {
            leaf = select(after_leaf, box_leaf, box_leaf != 0u);
            after_leaf = select(0u, after_leaf, box_leaf != 0u);
            box_leaf = 0u;
        }
        (*walk).hit = meet_triangle(leaf & FIRST_MASK, (*walk).ray, (*walk).hit, (*walk).kind);
        // The leaf without this triangle.
        leaf = select(leaf + 1u - (1u << COUNT_BITS), 0u, ((leaf >> COUNT_BITS) & 3u) == 0u);
    }
    if (*walk).kind == SHADOW && (*walk).hit.triangle != NONE {
        (*walk).next = (*walk).end;
    }
#ifdef MOVERS
    else if (*walk).next >= (*walk).end && (*walk).movers != 0u {
        go_on_with_movers(walk);
    }
#endif
}

fn trace(boxes: u32, ray: Ray, t_max: f32, kind: u32) -> Hit {
    var walk = begin_walk(load_frame(boxes), ray, t_max, kind);
    while !is_over(walk) {
        go_on(&walk);
    }
    return walk.hit;
}

// What glass leaves of light that comes along a SHADOW ray which nothing blocks.
fn passed(ray: Ray, hit: Hit) -> vec3f {
#ifdef GLASS
    return left_of(hit.taken, min(hit.t * length(ray.direction), 1e9));
#else
    return vec3f(1.0);
#endif
}

// What glass leaves of light on its way of so much of a LIGHT ray.
fn left_by_glass(boxes: u32, ray: Ray, reach: f32) -> vec3f {
#ifdef GLASS
    let inverse = inverse_direction(ray.direction);
    let a = (glass_box.low - ray.origin) * inverse;
    let b = (glass_box.high - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    if max(max(near.x, near.y), max(near.z, 0.0)) > min(min(far.x, far.y), min(far.z, reach)) {
        return vec3f(1.0);
    }
    return passed(ray, trace(boxes, ray, reach, THROUGH));
#else
    return vec3f(1.0);
#endif
}
