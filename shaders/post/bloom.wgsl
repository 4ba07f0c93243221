// Bloom: a pyramid of halved images, and back. Every texel gives as much light as it has, on each step: the weights of what
// one texel gives to those of the next level add up to the ratio of their areas (Burt and Adelson 1983).

struct Bloom {
    share: f32,            // of the wider image
}

@group(0) @binding(0) var<uniform> bloom: Bloom;
@group(0) @binding(1) var finer: texture_2d<f32>;
@group(0) @binding(2) var wider: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba32float, write>;

// Beyond the border the image goes on as it is there.
fn load(image: texture_2d<f32>, texel: vec2i) -> vec3f {
    return textureLoad(image, clamp(texel, vec2i(0), vec2i(textureDimensions(image)) - 1), 0).rgb;
}

// Halves an image by the quadratic B-spline's weights, (1, 3, 3, 1)/8 along each axis.
@compute @workgroup_size(8, 8)
fn down_main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(result)) {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0; i < 16; i++) {
        let offset = vec2i(i % 4, i / 4) - 1;
        let weight = select(vec2f(1.0), vec2f(3.0), (offset == vec2i(0)) | (offset == vec2i(1)));
        sum += weight.x * weight.y / 64.0 * load(finer, 2 * vec2i(thread.xy) + offset);
    }
    textureStore(result, thread.xy, vec4f(sum, 1.0));
}

// Twice as large by linear interpolation: repeated, that is the B-spline itself (Chaikin 1974), which shows no texels.
fn enlarged(texel: vec2i) -> vec3f {
    let near = texel >> vec2u(1u);
    let far = near + select(vec2i(-1), vec2i(1), (texel & vec2i(1)) == vec2i(1));
    return 0.5625 * load(wider, near) + 0.1875 * (load(wider, vec2i(far.x, near.y)) + load(wider, vec2i(near.x, far.y)))
        + 0.0625 * load(wider, far);
}

@compute @workgroup_size(8, 8)
fn up_main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(result)) {
        return;
    }
    let texel = vec2i(thread.xy);
    textureStore(result, texel, vec4f(mix(load(finer, texel), enlarged(texel), bloom.share), 1.0));
}
