#define_import_path lightwell::brdf

// glTF 2.0 metallic-roughness, appendix B, with KHR_materials_specular:
// f = (1 − max F)·ρ/π + F·D·V.

const PI: f32 = 3.14159265358979;

// Trowbridge-Reitz (GGX) distribution (Walter et al. 2007, eq. 33), alpha = roughness².
// Written with n×h, which keeps its precision where n·h is close to one.
fn distribution_ggx(n: vec3f, h: vec3f, alpha: f32) -> f32 {
    let n_cross_h = cross(n, h);
    let a = dot(n, h) * alpha;
    let k = alpha / max(dot(n_cross_h, n_cross_h) + a * a, 1e-20);
    return k * k / PI;
}

// Height-correlated Smith visibility G/(4·n·l·n·v) (Heitz 2014).
fn visibility_smith(n_dot_l: f32, n_dot_v: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    let l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    return 0.5 / max(v + l, 1e-20);
}

// Density of directions that are reflected at visible normals [1/sr]: that of the normals over 4·v·h, G₁(v)·D/(4·n·v)
// (Heitz 2018, eq. 17). h is a unit vector.
fn visible_normal_density(n: vec3f, h: vec3f, n_dot_v: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = distribution_ggx(n, h, alpha);
    return d / (2.0 * (n_dot_v + sqrt(a2 + (1.0 - a2) * n_dot_v * n_dot_v)));
}

// Schlick's Fresnel term.
fn fresnel_schlick(f0: vec3f, f90: f32, cosine: f32) -> vec3f {
    let m = saturate(1.0 - cosine);
    let m2 = m * m;
    return f0 + (vec3f(f90) - f0) * (m2 * m2 * m);
}

// Reflected over incident radiance times n·l [1/sr]. All vectors unit and pointing away from the surface.
fn eval_brdf_cosine(n: vec3f, v: vec3f, l: vec3f, albedo: vec3f, f0: vec3f, f90: f32, alpha: f32) -> vec3f {
    let n_dot_l = dot(n, l);
    if n_dot_l <= 0.0 {
        return vec3f(0.0);
    }
    let half_sum = v + l;
    let length_squared = dot(half_sum, half_sum);
    if length_squared < 1e-12 || all(f0 <= vec3f(0.0)) && f90 <= 0.0 {
        return albedo * (n_dot_l / PI);
    }
    let h = half_sum * inverseSqrt(length_squared);
    let f = fresnel_schlick(f0, f90, dot(v, h));
    let n_dot_v = max(dot(n, v), 1e-4);
    let specular = f * (distribution_ggx(n, h, alpha) * visibility_smith(n_dot_l, n_dot_v, alpha));
    let diffuse = (1.0 - max(f.r, max(f.g, f.b))) * albedo / PI;
    return (diffuse + specular) * n_dot_l;
}
