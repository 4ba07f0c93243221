#define_import_path lightwell::environment

// What a surface reflects of light from all around it, as far as that is even over the lobe.

// Share that the GGX lobe reflects of even light, ∫ F·D·V·cosθ = F0·A + F90·B: fits of A + B and B, see
// `render/environment.rs`.
fn lobe_reflectance(normal_reflectance: vec3f, grazing_reflectance: f32, roughness: f32, n_dot_v: f32) -> vec3f {
    let r = saturate(roughness);
    let x = saturate(n_dot_v);
    let whole = 1.0041 + x * (-0.0914 + x * (1.1917 + x * (-2.3978 + x * 1.2475)))
        + r * (-0.4462 + x * (-0.9961 + x * (3.586 - x * 1.5073))
        + r * (1.7534 + x * (-2.5879 - x * 0.3015)
        + r * (-2.2465 + x * 1.1552
        + r * 0.9313)));
    let s = 1.0 - r;
    let q = (1.0 - x) * (1.0 - x);
    let grazing = saturate(0.0043 - 0.0056 * r
        + q * (0.0354 + s * (0.0282 - s * 0.2741)
        + q * (-0.1957 + s * (1.1669 + s * 0.3073)
        + q * (0.2521 + s * (-1.7743 + s * 1.5272)))));
    return saturate(normal_reflectance * (whole - grazing) + grazing_reflectance * grazing);
}

// Direction that most of a lobe's light comes from: the mirror's for smooth surfaces, nearer to the normal for rough ones
// (Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", section 4.9.3, whose roughness is GGX α).
fn lobe_direction(n: vec3f, to_eye: vec3f, roughness: f32) -> vec3f {
    let alpha = roughness * roughness;
    let smoothness = 1.0 - alpha;
    let mirror = reflect(-to_eye, n);
    return normalize(mix(n, mirror, smoothness * (sqrt(smoothness) + alpha)));
}
