//! Golden images: the shipped scenes at chosen times look as they did when they were last looked at.
//!
//! A missing golden fails. `LIGHTWELL_BLESS=1` writes them anew: look at them before they are committed. Where a
//! picture differs, the actual and the difference picture lie beside the golden.

use lightwell::measure::{Image, compare, difference_picture, read_image, srgb_decode, write_image};
use lightwell::render::RenderSettings;
use lightwell_tests::{Stage, root};

/// Largest mean FLIP: above what drivers differ by, below what an eye sees in a flip comparison.
const MAX_FLIP: f64 = 0.01;

fn check(scene: &str, seconds: f64) {
    let mut stage = Stage::open(&root().join(format!("scenes/{scene}.scene.ron")), None, [128, 128]);
    stage.set_seconds(seconds);
    stage.draw(&RenderSettings::default(), [0.0; 2]);
    let actual: Image = stage.display().map(srgb_decode);
    let folder = root().join("tests/goldens");
    let name = format!("{scene}_{}ms", (seconds * 1000.0).round());
    let file = folder.join(format!("{name}.png"));
    if std::env::var_os("LIGHTWELL_BLESS").is_some() {
        std::fs::create_dir_all(&folder).expect("the folder of goldens");
        write_image(&file, &actual).unwrap_or_else(|error| panic!("{error}"));
        return;
    }
    let golden = read_image(&file).unwrap_or_else(|error| {
        panic!("{error}\nno golden for {scene} at {seconds} s: set LIGHTWELL_BLESS=1 to write it, and look at it")
    });
    let comparison = compare(&actual, &golden).unwrap_or_else(|error| panic!("{error}"));
    if comparison.flip > MAX_FLIP {
        let actual_file = folder.join(format!("{name}.actual.png"));
        let difference_file = folder.join(format!("{name}.difference.png"));
        write_image(&actual_file, &actual).unwrap_or_else(|error| panic!("{error}"));
        let difference = difference_picture(&actual, &golden).unwrap_or_else(|error| panic!("{error}"));
        write_image(&difference_file, &difference).unwrap_or_else(|error| panic!("{error}"));
        panic!(
            "{scene} at {seconds} s differs from its golden: mean FLIP {:.4} of at most {MAX_FLIP}; see {} and {}",
            comparison.flip,
            actual_file.display(),
            difference_file.display()
        );
    }
}

#[test]
fn cornell_at_the_start() {
    check("cornell", 0.0);
}

#[test]
fn cornell_after_a_second_and_a_half() {
    check("cornell", 1.5);
}

#[test]
fn cornell_after_four_seconds() {
    check("cornell", 4.0);
}

#[test]
fn prefabs_at_the_start() {
    check("prefabs", 0.0);
}
