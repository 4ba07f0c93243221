//! The report as Markdown: what is measured beside what the publication predicts, and its plots.

use super::super::picture;
use super::super::plot::{self, Curve};
use super::super::report::markdown::{error, percent, signed, table, whole};
use super::measure::VARIANTS;
use super::{Results, SceneResults, formulas};
use anyhow::Result;
use std::path::Path;

/// The whole report as Markdown.
pub(super) fn of(results: &Results) -> String {
    let mut text = format!(
        "# Instant radiosity, as the report has it\n\nThe figures of \"Virtual Point Lights\" (E. Franchi and L. Ferrante) in \
         scenes with its settings (`--set preset=report`), beside what it predicts: {}",
        results.header.in_words()
    );
    for scene in &results.scenes {
        text += &format!("## `{}`\n\n", scene.name);
        text += &casts(scene);
        text += &draws(scene);
        text += &errors(scene);
        text += &pictures(scene);
    }
    text
}

/// Writes the plots of all scenes.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn plots(results: &Results, folder: &Path) -> Result<()> {
    for scene in &results.scenes {
        let path = |what| folder.join(plot_file(scene, what));
        if !scene.casts.is_empty() {
            let title = format!("Intersection tests of a simulation: {}", scene.name);
            plot::sweep(&path("casts"), &title, &cast_curves(scene), "particles N")?;
        }
        if !scene.errors.is_empty() {
            let title = format!("nrmse of indirect light against the path tracer: {}", scene.name);
            plot::sweep(&path("errors"), &title, &error_curves(scene), "particles N")?;
        }
    }
    Ok(())
}

fn plot_file(scene: &SceneResults, what: &str) -> String {
    format!("plots/{}_{what}.png", picture::file_name(&scene.name))
}

fn cast_curves(scene: &SceneResults) -> Vec<Curve<'static>> {
    let mut rows: Vec<_> = scene.casts.iter().collect();
    rows.sort_by_key(|row| row.particles);
    let curve = |label, value: &dyn Fn(&super::CastRow) -> f64| Curve {
        label,
        points: rows.iter().map(|row| (f64::from(row.particles), value(row))).collect(),
    };
    vec![
        curve("B·N/(1−ρ)", &|row| formulas::bound(row.particles, row.reflectance, row.objects)),
        curve("objects, one by one", &|row| row.brute_force as f64),
        curve("boxes and triangles of the hierarchy", &|row| row.hierarchy as f64),
    ]
}

fn error_curves(scene: &SceneResults) -> Vec<Curve<'static>> {
    let of = |label: &'static str| {
        let mut rows: Vec<_> = scene.errors.iter().filter(|row| row.what == label).collect();
        rows.sort_by_key(|row| row.particles);
        Curve { label, points: rows.iter().map(|row| (f64::from(row.particles), row.nrmse)).collect() }
    };
    // The plot tells three colours apart: the report, its particles with shadows, and ours.
    [VARIANTS[0].0, VARIANTS[2].0, VARIANTS[3].0].map(of).into()
}

fn casts(scene: &SceneResults) -> String {
    let mut rows: Vec<_> = scene.casts.iter().collect();
    rows.sort_by_key(|row| row.particles);
    let cells = |row: &&super::CastRow| {
        let bound = formulas::bound(row.particles, row.reflectance, row.objects);
        vec![
            whole(row.particles.into()),
            whole(bound.round() as u64),
            whole(formulas::tests(row.particles, row.reflectance, row.objects)),
            whole(row.brute_force),
            percent(row.brute_force as f64 / bound),
            whole(row.hierarchy),
            format!("{} and {}", whole(row.bounds[0]), whole(row.bounds[1])),
        ]
    };
    let head = ["N", "B·N/(1−ρ)", "Σ B·⌊ρᵏN⌋", "objects tested", "of the bound", "hierarchy", "boxes, and triangles"];
    let rows: Vec<_> = rows.iter().map(cells).collect();
    let first = scene.casts.first();
    format!(
        "### Casts\n\nThe report bounds the ray-object tests of a simulation by B·N/(1−ρ); here B = {}, ρ = {:.3}. Particles \
         that leave the scene, or meet what reflects nothing, take fewer. Through the hierarchy boxes and triangles are \
         tested, and with `casts: Bounds` the boxes around objects, and the triangles of those that a ray starts within.\n\n\
         {}\n![Intersection tests over the number of particles]({})\n\n",
        first.map_or(0, |row| row.objects),
        first.map_or(0.0, |row| row.reflectance),
        table(&head, &rows),
        plot_file(scene, "casts")
    )
}

fn draws(scene: &SceneResults) -> String {
    let mut rows: Vec<_> = scene.draws.iter().collect();
    rows.sort_by_key(|row| row.particles);
    let cells = |row: &&super::DrawRow| {
        let parts = [row.shadows, row.camera, row.virtual_lights];
        let mut cells = vec![whole(row.particles.into()), whole(row.lights)];
        cells.extend(parts.map(whole));
        cells.extend([parts.iter().sum(), formulas::draws(row.lights, row.objects), row.batched].map(whole));
        cells
    };
    let rows: Vec<_> = rows.iter().map(cells).collect();
    let head = ["N", "M", "shadow maps", "camera", "virtual lights", "all", "(7 + M)·B", "one pass for all lights"];
    format!(
        "### Draws of a frame\n\nThe report takes (7 + M)·B draws: 6·B for the cube map, B for the main light, and B for each of \
         M virtual lights; here B = {}. Objects that a face of the map or the camera cannot see are left out, and a spot \
         light or the sun has one face alone. With all virtual lights in one pass, M is divided by their number, and what \
         is left are draws of the map and the camera.\n\n{}\n",
        scene.draws.first().map_or(0, |row| row.objects),
        table(&head, &rows)
    )
}

fn errors(scene: &SceneResults) -> String {
    let mut rows = Vec::new();
    for (what, ..) in VARIANTS {
        let mut of: Vec<_> = scene.errors.iter().filter(|row| row.what == what).collect();
        of.sort_by_key(|row| row.particles);
        rows.extend(of.into_iter().map(|row| {
            let errors = [error(row.nrmse), signed(row.bias), error(row.scaled), error(row.noise)];
            let mut cells = vec![what.to_owned(), whole(row.particles.into()), whole(row.lights)];
            cells.extend(errors);
            cells
        }));
    }
    let head = ["settings", "N", "M", "nrmse", "bias", "nrmse, scaled", "noise of the reference"];
    format!(
        "### Error over N\n\nIndirect light against the path tracer, without the sky. The published formula has neither \
         distance nor the cosine at the virtual light, so that with more particles its image nears another one; \"scaled\" \
         is what is left of the error when the image has the reference's mean. With the geometry term light still passes \
         through everything unless shadow rays stop it, and mirror bounces send it elsewhere than diffuse surfaces do.\n\n\
         {}\n![Error over the number of particles]({})\n\n",
        table(&head, &rows),
        plot_file(scene, "errors")
    )
}

fn pictures(scene: &SceneResults) -> String {
    let mut text =
        "### Pictures\n\nAs in the report: ten particles, the light with its shadows, each virtual light by itself \
                    (brighter than in the sum), and the ways of the particles.\n\n"
            .to_owned();
    for picture in &scene.pictures {
        text += &format!("![{}: {}]({})\n\n", scene.name, picture.what, picture.file);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::{CastRow, DrawRow, ErrorRow, Picture};
    use super::*;

    #[test]
    fn figures_stand_beside_what_is_predicted() {
        let casts = CastRow {
            particles: 10,
            objects: 9,
            reflectance: 0.5,
            lights: 18,
            rays: 18,
            brute_force: 162,
            hierarchy: 1234,
            bounds: [162, 24],
        };
        let draws =
            DrawRow { particles: 10, lights: 18, objects: 9, shadows: 40, camera: 8, virtual_lights: 144, batched: 48 };
        let error = ErrorRow {
            what: VARIANTS[0].0.into(),
            particles: 16,
            lights: 31,
            nrmse: 1.25,
            bias: -0.5,
            scaled: 0.4,
            noise: 0.01,
            course: String::new(),
        };
        let pictures = vec![Picture { what: "both".into(), file: "pictures/a.png".into(), course: String::new() }];
        let name = "vpl_report".to_owned();
        let scene = SceneResults { name, casts: vec![casts], draws: vec![draws], errors: vec![error], pictures };
        let text = of(&Results { scenes: vec![scene], ..Default::default() });
        for line in [
            "here B = 9, ρ = 0.500",
            "| 10 | 180 | 162 | 162 | 90 % | 1,234 | 162 and 24 |",
            "| 10 | 18 | 40 | 8 | 144 | 192 | 225 | 48 |",
            "| as the report | 16 | 31 | 1.250 | -0.500 | 0.400 | 0.010 |",
            "![vpl_report: both](pictures/a.png)",
            "(plots/vpl_report_casts.png)",
        ] {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
    }
}
