//! The report: each table and figure of the paper with our figures beside the printed ones.

use super::super::report::markdown::{NONE, error, ms, percent, signed, size, table, times as factor, whole};
use super::published::{BOUNDS, STEPS, SUBJECTS, Subject, TABLE_2, WAYS};
use super::{Counts, Measured, Results, SubjectResults};

const DEVIATIONS: &str = "## What deviates\n\n\
    - Scenes: editions of the models, cameras, lights and units are ours, and δ = 0.001 W/m² is of our units. One light feeds \
    one map of 256² texels. The Museum is not to be had: another scene stands in its place.\n\
    - Materials are not printed. Surfaces of the scenes of figure 9 all get F0 = 4 % and α = 0.1; those of figure 10 are gold. \
    Receivers are glossy too, where the paper speaks of light onto diffuse surfaces.\n\
    - A light is a disc of its texel's area: p = I/(δ(l² + A/π)) in place of I/(δl²), so that no light is brighter than its \
    surface.\n\
    - A diffuse lobe is what the specular reflection leaves, so that its intensity is below Φk/π; ranges are 0.1 % larger against \
    rounding.\n\
    - B·S is stored for each light. B·S·c is not: corners are taken relative to the centre first, which keeps digits.\n\
    - Clusters are found by boxes in a compute shader, which is conservative too, in place of conservative rasterization of 20 \
    triangles. Slices lie within the depths of each tile. Lights are kept as masks of bits in place of lists in 256 MB. A tile's \
    masks that do not fit are an error.\n\
    - Splatting adds in the blending unit at 32 bits a channel, diffuse and specular light apart.\n\
    - The cross bilateral filter compares planes and normals, and a tent takes the place of the weights that are not printed.\n\
    - Lights are counted over all pixels of one frame, the two lobes of a light apart. RMSE is that of linear radiance against \
    the sum over all lights at every pixel, of one image; the paper does not say of what unit and against what its own is.\n";

/// The whole report as Markdown.
pub(super) fn of(results: &Results) -> String {
    let mut text = format!(
        "# The culling paper, side by side\n\nTables 1 and 2 and figures 9 and 10 of Tokuyoshi and Harada (2017) with ours beside \
         them. Printed times are of a GeForce GTX 970 at 1920×1080. Ours: {}",
        results.header.in_words()
    );
    text += "Scenes are in the paper's settings (`--set preset=culling_paper`): 65,536 lights of one map, no visibility, 8 × 8 \
             interleaved, a filter of radius 8, δ = 0.001, independent ξ. A scene whose model is missing is replaced by its \
             stand-in.\n\n";
    text += &steps(results);
    text += &ways(results);
    text += &figure(results, false);
    text += &figure(results, true);
    text += &diffuse(results);
    text += &errors(results);
    text += &pictures(results);
    text += DEVIATIONS;
    text
}

/// The results with what the paper prints of them.
fn pairs(results: &Results) -> impl Iterator<Item = (&'static Subject, &SubjectResults)> {
    SUBJECTS.iter().filter_map(|paper| Some((paper, results.subjects.iter().find(|ours| ours.name == paper.name)?)))
}

/// Our name of a subject.
fn ours_of(paper: &Subject, ours: &SubjectResults) -> String {
    paper.roughness.map_or_else(|| format!("`{}`", ours.scene), |preset| format!("`{}`, `{preset}`", ours.scene))
}

/// Size and frames of the first subject.
fn caption(results: &Results) -> String {
    let first = results.subjects.first();
    first.map_or("not measured".to_owned(), |ours| format!("{}, medians of {} frames", size(ours.size), ours.frames))
}

fn steps(results: &Results) -> String {
    let mut rows = Vec::new();
    for (paper, ours) in pairs(results) {
        if let Some(times) = paper.times {
            let mut cells = vec![format!("{}, paper", paper.name)];
            cells.extend(times.map(|value| format!("{value:.3}")));
            rows.push(cells);
        }
        let mut cells = vec![ours_of(paper, ours)];
        cells.extend(ours.times.map(ms));
        rows.push(cells);
    }
    let head: Vec<&str> = ["scene [ms]"].into_iter().chain(STEPS).collect();
    format!(
        "## Table 1: times ({})\n\n{}\nTotals are sums of the columns; the printed one of Sibenik leaves out its 0.140 of lights \
         and ranges. The times of figures 9 and 10 are such totals.\n\n",
        caption(results),
        table(&head, &rows)
    )
}

fn ways(results: &Results) -> String {
    let mut text = format!("## Table 2: culling and shading ({})\n\n", caption(results));
    let mut refusals = Vec::new();
    for (lobe, what) in ["Diffuse", "Glossy"].into_iter().enumerate() {
        let mut rows = Vec::new();
        let [splats, clusters, tiles] = TABLE_2[lobe];
        for (index, ((splatting, clustered), tiled)) in splats.into_iter().zip(clusters).zip(tiles).enumerate() {
            let mut cells = vec![format!("paper, picture {}", index + 1)];
            cells.extend([splatting, clustered, tiled].map(|value| format!("{value:.2}")));
            cells.extend([splatting / tiled, clustered / tiled].map(factor));
            rows.push(cells);
        }
        for (paper, ours) in pairs(results) {
            let measured = &ours.ways[lobe];
            let value = |measured: &Measured| match measured {
                Measured::Ms(value) => Some(*value),
                Measured::Refused(_) => None,
            };
            let tiled = value(&measured[2]);
            let mut cells = vec![ours_of(paper, ours)];
            cells.extend(measured.iter().map(|one| value(one).map_or(NONE.to_owned(), ms)));
            let ratio = |one| Some(factor(value(one)? / tiled?));
            cells.extend(measured[..2].iter().map(|one| ratio(one).unwrap_or(NONE.to_owned())));
            rows.push(cells);
            for (one, way) in measured.iter().zip(WAYS) {
                if let Measured::Refused(why) = one {
                    refusals.push(format!("- {}, {way}: {why}\n", ours_of(paper, ours)));
                }
            }
        }
        let head = [
            &format!("{what} lights only [ms]"),
            "splatting",
            "clustered",
            "tiled",
            "splatting / tiled",
            "clustered / tiled",
        ];
        text += &format!("{}\n", table(&head, &rows));
    }
    text += "The paper's columns are pictures without names.\n\n";
    if !refusals.is_empty() {
        refusals.dedup();
        text += &format!("Not drawn, and nothing in its place:\n\n{}\n", refusals.concat());
    }
    text
}

/// Figure 9 or 10.
fn figure(results: &Results, series: bool) -> String {
    let mut rows = Vec::new();
    for (paper, ours) in pairs(results).filter(|(paper, _)| paper.is_of_the_series() == series) {
        for (index, (_, bound)) in BOUNDS.into_iter().enumerate() {
            let (total, lights, vain) = paper.bounds[index];
            let fewer = |vain: f64, most: f64| if index == 0 { NONE.to_owned() } else { percent(1.0 - vain / most) };
            let mut cells = vec![format!("{}, {bound}, paper", paper.name)];
            cells.extend([format!("{total:.2}"), format!("{lights:.1}"), format!("{vain:.1}")]);
            cells.extend([percent(vain / lights), fewer(vain, paper.bounds[0].2)]);
            rows.push(cells);
            let row = &ours.bounds[index];
            let mut cells = vec![format!("{}, {bound}", ours_of(paper, ours)), ms(row.total_ms)];
            cells.extend(counted(row.glossy));
            cells.push(fewer(row.glossy.in_vain(), ours.bounds[0].glossy.in_vain()));
            rows.push(cells);
        }
    }
    let (number, what) = if series { (10, "roughness") } else { (9, "scenes") };
    let head = ["bound", "frame [ms]", "glossy lights a pixel", "in vain", "share", "fewer in vain than (a)"];
    format!(
        "## Figure {number}: glossy lights, {what}\n\n{}\nThe paper says of its ellipsoids that lights in vain fall by over 90 % \
         (section 7). A tile of 16 × 16 pixels of a subset covers 128 × 128 of the image: in images of few tiles no bound culls \
         much.\n\n",
        table(&head, &rows)
    )
}

/// Lights, those in vain, and their share (the false discovery rate).
fn counted(counts: Counts) -> [String; 3] {
    let share = if counts.tested > 0.0 { percent(counts.in_vain() / counts.tested) } else { NONE.to_owned() };
    [format!("{:.1}", counts.tested), format!("{:.1}", counts.in_vain()), share]
}

fn diffuse(results: &Results) -> String {
    let mut rows = Vec::new();
    for (paper, ours) in pairs(results) {
        for (row, (_, bound)) in ours.bounds.iter().zip(BOUNDS) {
            let mut cells = vec![format!("{}, {bound}", ours_of(paper, ours))];
            cells.extend(counted(row.diffuse));
            rows.push(cells);
        }
    }
    let head = ["bound", "diffuse lights a pixel", "in vain", "share"];
    format!(
        "## Diffuse lights\n\nCounted apart; the paper prints none. Their bound is a sphere in any case, which the last two \
         rows share.\n\n{}\n",
        table(&head, &rows)
    )
}

fn errors(results: &Results) -> String {
    let mut rows = Vec::new();
    for (paper, ours) in pairs(results) {
        let printed = paper.rmse.map_or(NONE.to_owned(), |rmse| format!("{rmse:.4}"));
        let found = &ours.error;
        let cells = [printed, format!("{:.4}", found.rmse), error(found.nrmse), signed(found.bias), size(found.size)];
        rows.push([ours_of(paper, ours), whole(ours.triangles), whole(ours.lights)].into_iter().chain(cells).collect());
    }
    let head = ["scene", "triangles", "lights", "RMSE, paper", "RMSE [W/(m² sr)]", "nrmse", "bias", "size"];
    format!("## Errors\n\nOne image against the sum over all lights at every pixel.\n\n{}\n", table(&head, &rows))
}

fn pictures(results: &Results) -> String {
    let mut text =
        "## Pictures\n\nThe image, the sum over all lights, and the difference; glossy lights in vain for the three \
                    bounds, (a) to (c): black 0, blue 171, green 341, red 512 or more.\n\n"
            .to_owned();
    for (paper, ours) in pairs(results) {
        for file in &ours.pictures {
            text += &format!("![{}]({file})\n\n", ours_of(paper, ours));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::{BoundRow, Error};
    use super::*;

    fn row(total_ms: f64, tested: f64, accepted: f64) -> BoundRow {
        let counts = |scale: f64| Counts { tested: scale * tested, accepted: scale * accepted };
        BoundRow { total_ms, glossy: counts(1.0), diffuse: counts(2.0) }
    }

    #[test]
    fn our_figures_stand_beside_the_printed_ones() {
        let refused = Measured::Refused("needs an adapter that blends".to_owned());
        let museum = SubjectResults {
            name: "Museum".into(),
            scene: "night_court".into(),
            triangles: 265_600,
            lights: 65_536,
            size: [64, 32],
            frames: 3,
            times: [1.0, 2.0, 3.0, 4.0, 5.0, 15.0],
            ways: [
                [Measured::Ms(8.0), Measured::Ms(6.0), Measured::Ms(4.0)],
                [refused, Measured::Ms(3.0), Measured::Ms(2.0)],
            ],
            bounds: [row(40.0, 101.0, 1.0), row(20.0, 51.0, 1.0), row(15.0, 11.0, 1.0)],
            error: Error { size: [16, 16], rmse: 0.5, nrmse: 0.25, bias: -0.125 },
            pictures: vec!["pictures/Museum.png".into()],
        };
        let series = SubjectResults { name: "roughness 0.1".into(), scene: "glossy_ring".into(), ..museum.clone() };
        let text = of(&Results { subjects: vec![museum, series], ..Default::default() });
        for line in [
            "| Museum, paper | 0.986 | 0.610 | 0.136 | 7.398 | 1.320 | 10.450 |",
            "| `night_court` | 1.00 | 2.00 | 3.00 | 4.00 | 5.00 | 15.0 |",
            "| paper, picture 1 | 17.05 | 12.69 | 3.75 | 4.5× | 3.4× |",
            "| `night_court` | 8.00 | 6.00 | 4.00 | 2.0× | 1.5× |",
            "| `night_court` | – | 3.00 | 2.00 | – | 1.5× |",
            "- `night_court`, splatting: needs an adapter that blends",
            "| Museum, ellipsoid, paper | 11.19 | 18.3 | 16.5 | 90 % | 92 % |",
            "| `night_court`, ellipsoid | 15.0 | 11.0 | 10.0 | 91 % | 90 % |",
            "| `night_court`, sphere centred at the light | 40.0 | 101.0 | 100.0 | 99 % | – |",
            "| `glossy_ring`, `roughness_0.1`, ellipsoid | 15.0 | 11.0 | 10.0 | 91 % | 90 % |",
            "| `night_court`, ellipsoid | 22.0 | 20.0 | 91 % |",
            "| `night_court` | 265,600 | 65,536 | 0.0213 | 0.5000 | 0.250 | -0.125 | 16×16 |",
            "![`night_court`](pictures/Museum.png)",
            "## What deviates",
        ] {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
    }
}
