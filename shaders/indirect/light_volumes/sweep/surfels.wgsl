// Surfels from object to world space. Their areas and thicknesses are in metres already: they change only with an
// object's scale, and then the cloud is rebuilt.

#import lightwell::mesh::normalize_or_zero
#import lightwell::sweep::{Surfel, INDEX}

struct Place {
    rows: array<vec4f, 3>, // world from object space
}

@group(0) @binding(0) var<storage, read> cloud: array<Surfel>;
@group(0) @binding(1) var<storage, read> places: array<Place>;
@group(0) @binding(2) var<storage, read_write> surfels: array<Surfel>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&cloud) {
        return;
    }
    var surfel = cloud[index];
    let place = places[surfel.place & INDEX];
    let p = vec4f(surfel.position, 1.0);
    surfel.position = vec3f(dot(place.rows[0], p), dot(place.rows[1], p), dot(place.rows[2], p));
    // Normals by the cofactor matrix, its sign taken out: mirrored objects keep their outside.
    let a = place.rows[0].xyz;
    let b = place.rows[1].xyz;
    let c = place.rows[2].xyz;
    let bc = cross(b, c);
    let n = surfel.normal;
    let mirrored = select(1.0, -1.0, dot(a, bc) < 0.0);
    surfel.normal = mirrored * normalize_or_zero(vec3f(dot(bc, n), dot(cross(c, a), n), dot(cross(a, b), n)));
    surfels[index] = surfel;
}
