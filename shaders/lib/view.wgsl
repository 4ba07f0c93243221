#define_import_path lightwell::view

// The view that a frame is drawn from.
struct View {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    eye: vec3f,
    size: vec2u,           // [pixels]
}
