//! The raster image and the path tracer against images of an independent renderer. They lie in the folder that `LIGHTWELL_REFERENCE`
//! names, and the real models in that of `LIGHTWELL_MODELS`; without them the tests are ignored.

use lightwell::measure::{compare, read_image};
use lightwell::render::reference::{Estimate, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell_needs::needs;
use lightwell_tests::{Stage, folder_from_env, root};
use std::path::Path;

/// Direct light alone differs by shadow borders and the edges of pixels, and by nothing else.
fn direct_light_of(scene: &str) {
    let folder = folder_from_env("LIGHTWELL_REFERENCE");
    let folder = folder.join(scene);
    let reference = read_image(&folder.join("direct.exr")).unwrap_or_else(|error| panic!("{error}"));
    let mut stage = Stage::open(&folder.join("scene.glb"), None, reference.size());
    let settings =
        RenderSettings { gi: GiMethod::NONE, only: Layer::Direct, display: false, ..RenderSettings::default() };
    let image = stage.averaged(&settings, 16);
    let comparison = compare(&image, &reference).unwrap_or_else(|error| panic!("{error}"));
    let (nrmse, bias) = (comparison.nrmse, comparison.bias);
    eprintln!("{scene}: nrmse {nrmse:.4}, bias {bias:.4}");
    assert!(nrmse < 0.05 && bias.abs() < 0.01, "{scene}: nrmse {nrmse:.4}, bias {bias:.4}");
}

#[needs("LIGHTWELL_REFERENCE")]
fn direct_light_of_the_cornell_box() {
    direct_light_of("cornell");
}

#[needs("LIGHTWELL_REFERENCE")]
fn direct_light_of_the_diffuse_cubes() {
    direct_light_of("bleeding_diffuse");
}

#[needs("LIGHTWELL_REFERENCE")]
fn direct_light_of_the_glossy_cubes() {
    direct_light_of("bleeding_gloss");
}

/// The path tracer differs from the independent images by noise alone: the error is that of both noises together, and
/// the mean is right to half a percent.
fn traced_light_of(scene: &str) {
    let folder = folder_from_env("LIGHTWELL_REFERENCE");
    let folder = folder.join(scene);
    let meta = std::fs::read_to_string(folder.join("meta.json")).expect("meta.json");
    let mut stage = Stage::open(&folder.join("scene.glb"), None, [512, 512]);
    stage.set_seconds(0.0);
    for (bounces, name) in [(Some(1), "indirect_k1"), (Some(2), "indirect_k2"), (None, "indirect_inf")] {
        let estimate = stage.trace(&TraceSettings { bounces, seed: 11 }, 8);
        if bounces == Some(1) {
            assert_is_noise(scene, "direct", &estimate, Layer::Direct, &folder, &meta);
        }
        assert_is_noise(scene, name, &estimate, Layer::Indirect, &folder, &meta);
    }
}

fn assert_is_noise(scene: &str, name: &str, estimate: &Estimate, layer: Layer, folder: &Path, meta: &str) {
    let reference = read_image(&folder.join(format!("{name}.exr"))).unwrap_or_else(|error| panic!("{error}"));
    let image = if layer == Layer::Direct { estimate.direct() } else { estimate.indirect() };
    let comparison = compare(&image, &reference).unwrap_or_else(|error| panic!("{error}"));
    let noise = estimate.noise(layer).expect("finite images").hypot(noise_in(meta, name));
    let (nrmse, bias) = (comparison.nrmse, comparison.bias);
    eprintln!("{scene} {name}: nrmse {nrmse:.4}, both noises {noise:.4}, bias {bias:+.5}");
    assert!(nrmse < 1.3 * noise, "{scene} {name}: nrmse {nrmse:.4} is more than noise of {noise:.4}");
    assert!(bias.abs() < 0.005, "{scene} {name}: bias {bias:+.5}");
}

/// `noise_nrmse` of an image in `meta.json`.
fn noise_in(meta: &str, image: &str) -> f64 {
    let meta: serde_json::Value = serde_json::from_str(meta).expect("JSON");
    meta["images"][image]["noise_nrmse"].as_f64().expect("the noise of the image")
}

#[needs("LIGHTWELL_REFERENCE")]
fn traced_light_of_the_cornell_box() {
    traced_light_of("cornell");
}

#[needs("LIGHTWELL_REFERENCE")]
fn traced_light_of_the_diffuse_cubes() {
    traced_light_of("bleeding_diffuse");
}

#[needs("LIGHTWELL_REFERENCE")]
fn traced_light_of_the_glossy_cubes() {
    traced_light_of("bleeding_gloss");
}

#[needs("LIGHTWELL_MODELS")]
fn shadowed_aisles_of_sponza_get_indirect_light() {
    let models = folder_from_env("LIGHTWELL_MODELS");
    let mut stage = Stage::open(&root().join("scenes/sponza.scene.ron"), Some(models), [256, 144]);
    stage.draw(&RenderSettings { gi: GiMethod::NONE, ..RenderSettings::default() }, [0.0; 2]);
    let direct = stage.radiance();
    stage.draw(&RenderSettings { only: Layer::Indirect, ..RenderSettings::default() }, [0.0; 2]);
    let indirect = stage.radiance();
    let unlit = direct.pixels().iter().zip(indirect.pixels()).filter(|(direct, _)| **direct == [0.0; 3]);
    let (mut count, mut reached) = (0, 0);
    for (_, indirect) in unlit {
        count += 1;
        reached += usize::from(indirect.iter().any(|&c| c > 0.0));
    }
    assert!(count > 1000, "only {count} pixels lie in shadow");
    assert!(reached * 100 > count * 90, "indirect light reaches {reached} of {count} pixels in shadow");
}
