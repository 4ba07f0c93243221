#define_import_path lightwell::environment

// What a surface reflects of light from all around it, as far as that is even over the lobe.

// Share that the GGX lobe reflects of even light, ∫ F·D·V·cosθ: a fit of the split sum's table (Karis 2014, "Physically
// based shading on mobile", after Lazarov 2013).
fn lobe_reflectance(normal_reflectance: vec3f, grazing_reflectance: f32, roughness: f32, n_dot_v: f32) -> vec3f {
    let r = roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
    let scale_and_bias = vec2f(-1.04, 1.04) * a + r.zw;
    return saturate(normal_reflectance * scale_and_bias.x + grazing_reflectance * max(scale_and_bias.y, 0.0));
}

// Direction that most of a lobe's light comes from: the mirror's for smooth surfaces, nearer to the normal for rough ones
// (Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", section 4.9.3).
fn lobe_direction(n: vec3f, to_eye: vec3f, roughness: f32) -> vec3f {
    let smoothness = 1.0 - roughness;
    let mirror = reflect(-to_eye, n);
    return normalize(mix(n, mirror, smoothness * (sqrt(smoothness) + roughness)));
}
