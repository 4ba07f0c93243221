#define_import_path lightwell::bilateral

// How much a neighbouring pixel counts in a cross bilateral filter: by how far it lies off the surface, and how far that
// turns. Where a surface curves, chords are perpendicular to the mean of the normals at their ends, exactly so on spheres
// and cylinders: an elevation against that tells a step from a curve. Normals may turn by 20° within the radius before
// neighbours count for less, or what is round shows the pattern of the samples.
fn likeness(position: vec3f, n: vec3f, other_position: vec3f, other_n: vec3f) -> f32 {
    let offset = other_position - position;
    let across = dot(offset, offset);
    let both = n + other_n;
    let off_surface = dot(both, offset);
    let elevation = off_surface * off_surface / max(across * dot(both, both), 1e-30);
    let turned = (1.0 - dot(n, other_n)) / 0.15;
    return exp(-elevation * 50.0 - turned * turned);
}
