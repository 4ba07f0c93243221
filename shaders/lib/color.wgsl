#define_import_path lightwell::color

// Luminance of linear light with the primaries of ITU-R BT.709.
fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}
