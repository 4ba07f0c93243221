#define_import_path lightwell::walk

// The way of rays through the scene's hierarchies: along lists of boxes, or with WIDE through nodes of eight children.

#ifdef GLASS
#import lightwell::glass::left_of
#import lightwell::ray_scene::glass_box
#endif
#import lightwell::ray_scene::{NONE, load_node}
#import lightwell::rays::{Hit, Ray, SHADOW, inverse_direction, meet_triangle, no_hit, octant}
#ifdef CLASSES
#import lightwell::rays::{accepted, candidate}
#endif
#ifdef GLASS
#import lightwell::rays::{PANE, THROUGH}
#endif
#ifdef WIDE
#import lightwell::wide_nodes::{OFFSET_BITS, child_in, met_children, word_of}
#else
#import lightwell::ray_scene::{COUNT_BITS, FIRST_MASK, LEAF}
#endif

#ifdef WIDE
// What a ray begins with: whether there is anything to meet.
struct Frame {
    nodes: u32,
}

fn load_frame(nodes: u32) -> Frame {
    return Frame(nodes);
}

// A ray on its way through nodes of eight children.
struct Walk {
    ray: Ray,
    inverse: vec3f,
    signs: u32,            // of its direction
    // Nodes to be looked at, children of one node: the first of its children, and below 8 bits that say in which slots
    // nodes are, 8 that say which of these are still to be looked at, in the order of the ray.
    first_child: u32,
    children: u32,
    waiting: u32,          // such groups that are to be looked at after them
    kind: u32,
    hit: Hit,              // so far
}

// Groups that wait: as many as there can be nodes from the root to a leaf, 24 in each of two hierarchies (see
// rays/wide_tree.rs).
var<private> waiting: array<vec2u, 48>;

// A ray at its start; one without reach is over already.
fn begin_walk(frame: Frame, ray: Ray, reach: f32, kind: u32) -> Walk {
    let signs = octant(ray.direction);
    // The root, as if it were in the first slot of a node: on the ray's way that is the slot of its octant.
    let root = select(0u, 0x100u | (1u << signs), frame.nodes > 0u && reach > 0.0);
    return Walk(ray, inverse_direction(ray.direction), signs, 0u, root, 0u, kind, no_hit(reach));
}

fn is_over(walk: Walk) -> bool {
    return (walk.children & 0xffu) == 0u;
}

// Looks into the nearest node that is to be looked at, and at once into the leaves that are met there. The walk must not be
// over.
fn go_on(walk: ptr<function, Walk>) {
    let signs = (*walk).signs;
    let child = firstTrailingBit((*walk).children);
    let node = child_in(child ^ signs, (*walk).first_child, (*walk).children >> 8u);
    let left = (*walk).children & ((*walk).children - 1u);
    if (left & 0xffu) != 0u {
        waiting[(*walk).waiting] = vec2u((*walk).first_child, left);
        (*walk).waiting += 1u;
    }
    let met = met_children(node, (*walk).ray.origin, (*walk).inverse, signs, (*walk).hit.t);
    (*walk).first_child = met.first_child;
    (*walk).children = met.inner | (met.all_inner << 8u);
    var leaves = met.leaves;
    var done = 0u;
    while leaves != 0u {
        let word = word_of(met.words, firstTrailingBit(leaves) ^ signs);
        let triangle = met.first_triangle + (word & ((1u << OFFSET_BITS) - 1u)) + done;
        let is_last = done == (word >> OFFSET_BITS);
        (*walk).hit = meet_triangle(triangle, (*walk).ray, (*walk).hit, (*walk).kind, false);
        done = select(done + 1u, 0u, is_last);
        leaves = select(leaves, leaves & (leaves - 1u), is_last);
    }
    if (*walk).kind == SHADOW && (*walk).hit.triangle != NONE {
        (*walk).children = 0u;
    } else if met.inner == 0u && (*walk).waiting != 0u {
        (*walk).waiting -= 1u;
        let group = waiting[(*walk).waiting];
        (*walk).first_child = group.x;
        (*walk).children = group.y;
    }
}
#else
// Where the boxes lie.
struct Frame {
    origin: vec3f,
    unit: vec3f,
    boxes: u32,            // of a list
    movers: u32,           // where those of dynamic objects begin; 0: nothing does
}

// `boxes` is the number of boxes of a list of static objects, which the host knows.
fn load_frame(boxes: u32) -> Frame {
    let second = load_node(1u);
#ifdef EXACT_BOXES
    return Frame(vec3f(0.0), vec3f(1.0), boxes, second.w);
#else
    let origin = bitcast<vec3f>(load_node(0u).xyz);
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
    let boxes = load_node(2u * place).w;
#else
    let header = load_node(place);
    let boxes = header.w;
    let unit = bitcast<vec3f>(load_node(place + 1u).xyz);
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
    let low = load_node(2u * index);
    let high = load_node(2u * index + 1u);
    return Box(bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz), low.w);
#else
    let words = load_node(index);
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

fn is_over(walk: Walk) -> bool {
    return walk.next >= walk.end;
}

// Leaves whose boxes are met and that are still to be looked into: one of earlier boxes, and those of the last two boxes.
struct Leaves {
    earlier: u32,          // 0: none
    last_but_one: u32,
    last: u32,
}

fn no_leaves() -> Leaves {
    return Leaves(0u, 0u, 0u);
}

fn count_leaves(leaves: Leaves) -> u32 {
    return u32(leaves.earlier != 0u) + u32(leaves.last_but_one != 0u) + u32(leaves.last != 0u);
}

// The box behind is the next one of most rays, and both at once take not much longer than one: most of the time goes into
// waiting, for memory and for one result after another. What lies behind the list's end leads nowhere or is met in vain.
fn look_at_boxes(walk: ptr<function, Walk>, leaves: ptr<function, Leaves>) {
    let box = load_box((*walk).next);
    let after = load_box((*walk).next + 1u);
    let is_leaf = box.link >= LEAF;
    let is_after_leaf = after.link >= LEAF;
    let is_met = meets_box(box, *walk);
    let is_after_met = meets_box(after, *walk);
    let reaches_after = is_met || is_leaf;
    (*leaves).earlier |= (*leaves).last_but_one | (*leaves).last;
    (*leaves).last_but_one = select(0u, box.link, is_met && is_leaf);
    (*leaves).last = select(0u, after.link, reaches_after && is_after_met && is_after_leaf);
    let after_next = select(after.link, (*walk).next + 2u, is_after_met || is_after_leaf);
    (*walk).next = select(box.link, after_next, reaches_after);
}

// A triangle of the leaves, of which there must be one; they are without it then.
fn take_triangle(leaves: ptr<function, Leaves>) -> u32 {
    if (*leaves).earlier == 0u {
        let has_two = (*leaves).last_but_one != 0u;
        (*leaves).earlier = select((*leaves).last, (*leaves).last_but_one, has_two);
        (*leaves).last = select(0u, (*leaves).last, has_two);
        (*leaves).last_but_one = 0u;
    }
    let leaf = (*leaves).earlier;
    (*leaves).earlier = select(leaf + 1u - (1u << COUNT_BITS), 0u, ((leaf >> COUNT_BITS) & 3u) == 0u);
    return leaf & FIRST_MASK;
}

// Looks at boxes until there are two leaves or more, or nothing is left, and then into the leaves: adapters that run
// lanes in lockstep let no lane look into one while others search (Aila and Laine 2009, "Understanding the efficiency
// of ray traversal on GPUs"). The walk must not be over. `is_opaque`: what it comes by is, a constant.
fn go_along(walk: ptr<function, Walk>, is_opaque: bool) {
    var leaves = no_leaves();
    loop {
        look_at_boxes(walk, &leaves);
        continuing {
            break if count_leaves(leaves) >= 2u || (*walk).next >= (*walk).end;
        }
    }
    while count_leaves(leaves) != 0u {
        (*walk).hit = meet_triangle(take_triangle(&leaves), (*walk).ray, (*walk).hit, (*walk).kind, is_opaque);
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
#endif

#ifndef WIDE
fn go_on(walk: ptr<function, Walk>) {
    go_along(walk, false);
}
#endif

#ifdef CLASSES
// The first box of what is opaque in a list that has two parts: that behind all that is not, whose root is the second box.
fn first_opaque(first: u32) -> u32 {
    let link = load_box(first + 1u).link;
    return select(link, first + 2u, link >= LEAF);
}

// The way along all that is opaque. Rays that ask for glass alone have none.
fn begin_opaque(frame: Frame, ray: Ray, reach: f32, kind: u32) -> Walk {
    var walk = begin_walk(frame, ray, reach, kind);
#ifdef SPLIT
    walk.next = select(walk.end, first_opaque(walk.next), reach > 0.0);
#endif
#ifdef GLASS
    walk.next = select(walk.next, walk.end, kind == THROUGH || kind == PANE);
#endif
#ifdef OTHER_MOVERS
    walk.movers = 0u;
#endif
    return walk;
}

// The way along the rest, as far as the ray still reaches.
fn begin_rest(frame: Frame, before: Walk) -> Walk {
    let is_blocked = before.kind == SHADOW && before.hit.triangle != NONE;
    let reach = select(before.hit.t, 0.0, is_blocked);
    var walk = begin_walk(frame, before.ray, reach, before.kind);
    walk.hit = before.hit;
#ifdef SPLIT
    let first = min(walk.next + 1u, walk.end);
    walk.end = select(walk.end, first_opaque(walk.next), first < walk.end);
    walk.next = first;
#else
    walk.next = walk.end;
#endif
#ifdef OTHER_MOVERS
    walk.movers = select(0u, walk.movers, reach > 0.0);
#ifndef SPLIT
    if walk.movers != 0u {
        go_on_with_movers(&walk);
    }
#endif
#else
#ifdef MOVERS
    walk.movers = 0u;
#endif
#endif
    return walk;
}
#endif

#ifdef CLASSES
// Goes along, as `go_along`, until a triangle is met, whatever its alpha, or nothing is left: the hit so far then.
fn next_candidate(walk: ptr<function, Walk>, leaves: ptr<function, Leaves>) -> Hit {
    var met = (*walk).hit;
    loop {
        while count_leaves(*leaves) < 2u && (*walk).next < (*walk).end {
            look_at_boxes(walk, leaves);
        }
        while count_leaves(*leaves) != 0u && met.triangle == (*walk).hit.triangle {
            met = candidate(take_triangle(leaves), (*walk).ray, (*walk).hit, (*walk).kind, false);
        }
#ifdef MOVERS
        if count_leaves(*leaves) == 0u && (*walk).next >= (*walk).end && (*walk).movers != 0u {
            go_on_with_movers(walk);
        }
#endif
        let is_through = count_leaves(*leaves) == 0u && (*walk).next >= (*walk).end;
        if is_through || met.triangle != (*walk).hit.triangle {
            break;
        }
    }
    return met;
}

// The way along what is not opaque. The loop over boxes knows nothing of alpha and glass here either: both are looked at where
// it has met a triangle, since adapters that run lanes in lockstep would look at them at every step.
fn trace_rest(frame: Frame, before: Walk) -> Hit {
    var walk = begin_rest(frame, before);
    var leaves = no_leaves();
    loop {
        let met = next_candidate(&walk, &leaves);
        if met.triangle == walk.hit.triangle {
            break;
        }
        walk.hit = accepted(met, walk.hit, walk.ray, walk.kind);
        if walk.kind == SHADOW && walk.hit.triangle != NONE {
            break;
        }
    }
    return walk.hit;
}
#endif

// What the ray meets, in a frame that was loaded before. With CLASSES it goes along all that is opaque first.
fn trace_in(frame: Frame, ray: Ray, t_max: f32, kind: u32) -> Hit {
#ifdef CLASSES
    var opaque = begin_opaque(frame, ray, t_max, kind);
    while !is_over(opaque) {
        go_along(&opaque, true);
    }
    return trace_rest(frame, opaque);
#else
    var walk = begin_walk(frame, ray, t_max, kind);
    while !is_over(walk) {
        go_on(&walk);
    }
    return walk.hit;
#endif
}

fn trace(boxes: u32, ray: Ray, t_max: f32, kind: u32) -> Hit {
    return trace_in(load_frame(boxes), ray, t_max, kind);
}

// What glass leaves of light that comes along a SHADOW ray which nothing blocks.
fn passed(ray: Ray, hit: Hit) -> vec3f {
#ifdef GLASS
    return left_of(hit.taken, min(hit.t * length(ray.direction), 1e9));
#else
    return vec3f(1.0);
#endif
}

#ifdef GLASS
// Whether a ray comes by where there is glass.
fn comes_by_glass(ray: Ray, reach: f32) -> bool {
    let inverse = inverse_direction(ray.direction);
    let a = (glass_box.low - ray.origin) * inverse;
    let b = (glass_box.high - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    return max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, reach));
}
#endif

// What glass leaves of light on its way of so much of a LIGHT ray.
fn left_by_glass(boxes: u32, ray: Ray, reach: f32) -> vec3f {
#ifdef GLASS
    if !comes_by_glass(ray, reach) {
        return vec3f(1.0);
    }
    return passed(ray, trace(boxes, ray, reach, THROUGH));
#else
    return vec3f(1.0);
#endif
}
