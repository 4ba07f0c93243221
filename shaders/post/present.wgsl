// Puts the display image on the window, pixel by pixel. Both hold sRGB-encoded values.

@group(0) @binding(0) var image: texture_2d<f32>;

// One triangle that covers the screen.
@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u));
    return vec4f(corner * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // The window may just have been resized: the border repeats then.
    let last = textureDimensions(image) - 1u;
    return vec4f(textureLoad(image, min(vec2u(position.xy), last), 0).rgb, 1.0);
}
