//! `rooms.md`: distributions of errors over rooms, and the worst of them.

use super::distribution::{SHARES, percentiles};
use super::figures::{Figures, PartError, RoomError, RoomFigures};
use super::{WORST, worst_picture, worst_scene};
use crate::bench::report::markdown;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The report.
pub fn text(figures: &Figures) -> String {
    let header = &figures.header;
    let mut text = format!("# Random rooms: {}\n\n{}.\n\n", figures.rooms.len(), header.settings);
    let commit = header.commit.as_deref().unwrap_or("unknown");
    let _ = writeln!(
        text,
        "Adapter {}, driver {}, {}. Version {}, commit {commit}. {}.\n",
        header.adapter, header.driver, header.system, header.version, header.date
    );
    text += "Errors are those of linear radiance against our path tracer with all bounces; its noise is removed by two \
             independent halves. nrmse: root mean square error over the mean of the reference; bias: relative error of \
             the mean. Percentiles over rooms are by nearest rank. A single image samples pixels at their centres, the \
             reference their whole area: along edges its error holds that difference too.\n\n";
    for method in &figures.methods {
        let images =
            if method.images == 1 { "one image".to_owned() } else { format!("{} images averaged", method.images) };
        let _ = writeln!(text, "- **{}**: {}, {images}", method.name, method.what);
    }
    text += &references(&figures.rooms);
    let all: Vec<&RoomFigures> = figures.rooms.iter().collect();
    text += "\n## Indirect light\n\n";
    text += &distribution(figures, &all, |error| (error.indirect.nrmse, error.indirect.bias));
    text += "\n## All light\n\n";
    text += &distribution(figures, &all, |error| (error.total.nrmse, error.total.bias));
    text += &edges(figures);
    text += &groups(figures);
    text += &worst(figures);
    text
}

fn references(rooms: &[RoomFigures]) -> String {
    let samples: Vec<f64> = rooms.iter().map(|room| f64::from(room.reference.samples)).collect();
    let noise: Vec<f64> = rooms.iter().map(|room| room.reference.noise).collect();
    let [median, most] = percentiles(&samples, [0.5, 1.0]);
    let [usual, noisiest] = percentiles(&noise, [0.5, 1.0]);
    let limited = rooms.iter().filter(|room| room.reference.limited).count();
    let further: Vec<f64> = rooms.iter().map(|room| room.reference.further_bounces).collect();
    let [further] = percentiles(&further, [0.5]);
    format!(
        "\nReferences: {median:.0} samples a pixel in the median, {most:.0} at most; noise {} and {}. In {limited} rooms \
         the limit of samples came before the noise was a quarter of the least error. Bounces after the first make {} of \
         the indirect light in the median.\n",
        markdown::percent(usual),
        markdown::percent(noisiest),
        markdown::percent(further),
    )
}

fn error_of<'a>(room: &'a RoomFigures, method: &str) -> Option<&'a RoomError> {
    room.errors.iter().find(|error| error.method == method)
}

fn values(rooms: &[&RoomFigures], method: &str, value: impl Fn(&RoomError) -> Option<f64>) -> Vec<f64> {
    rooms.iter().filter_map(|room| value(error_of(room, method)?)).collect()
}

fn cell(value: f64) -> String {
    if value.is_nan() { markdown::NONE.to_owned() } else { markdown::error(value) }
}

fn distribution(figures: &Figures, rooms: &[&RoomFigures], of: impl Fn(&RoomError) -> (f64, f64)) -> String {
    let head = ["method", "", "median", "75 %", "90 %", "95 %", "worst", "mean bias"];
    let mut rows = Vec::new();
    for method in &figures.methods {
        let nrmse = values(rooms, &method.name, |error| Some(of(error).0));
        let bias = values(rooms, &method.name, |error| Some(of(error).1));
        let size: Vec<f64> = bias.iter().map(|bias| bias.abs()).collect();
        let mean = bias.iter().sum::<f64>() / bias.len().max(1) as f64;
        let row = |name: &str, what: &str, values: &[f64], last: String| {
            let cells = percentiles(values, SHARES).map(cell);
            [name.to_owned(), what.to_owned()].into_iter().chain(cells).chain([last]).collect()
        };
        rows.push(row(&method.name, "nrmse", &nrmse, String::new()));
        rows.push(row("", "abs(bias)", &size, markdown::signed(mean)));
    }
    markdown::table(&head, &rows)
}

fn edges(figures: &Figures) -> String {
    let rooms: Vec<&RoomFigures> = figures.rooms.iter().collect();
    let share: Vec<f64> = rooms.iter().map(|room| room.reference.near_edges).collect();
    let [share] = percentiles(&share, [0.5]);
    let mut text = format!(
        "\n## Near edges and elsewhere\n\nNrmse of indirect light over the mean of the whole image, within {} pixels of a \
         geometric edge ({} of the pixels in the median room) and elsewhere.\n\n",
        super::edges::NEAR,
        markdown::percent(share)
    );
    let mut rows = Vec::new();
    for method in &figures.methods {
        let of = |part: fn(&RoomError) -> Option<PartError>| {
            percentiles(&values(&rooms, &method.name, |error| part(error).map(|part| part.nrmse)), [0.5, 0.9, 1.0])
                .map(cell)
        };
        let cells = of(|error| error.edges).into_iter().chain(of(|error| error.elsewhere));
        rows.push([method.name.clone()].into_iter().chain(cells).collect());
    }
    let head = ["method", "edges: median", "90 %", "worst", "elsewhere: median", "90 %", "worst"];
    text += &markdown::table(&head, &rows);
    text
}

fn size_class(room: &RoomFigures) -> &'static str {
    match room.facts.size.into_iter().fold(0.0, f64::max) {
        longest if longest < 2.0 => "below 2 m",
        longest if longest < 6.0 => "below 6 m",
        _ => "6 m and more",
    }
}

fn groups(figures: &Figures) -> String {
    type Group = fn(&RoomFigures) -> String;
    let kinds: [(&str, Group); 7] = [
        ("orientation", |room| room.facts.orientation.in_words().to_owned()),
        ("openness", |room| room.facts.openness.clone()),
        ("rooms", |room| room.facts.rooms.to_string()),
        ("size", |room| size_class(room).to_owned()),
        ("light", |room| if room.facts.glows { "something glows" } else { "lights and sky alone" }.to_owned()),
        ("clutter", |room| if room.facts.cluttered { "cluttered" } else { "not cluttered" }.to_owned()),
        ("materials", |room| if room.facts.glossy { "some glossy" } else { "none glossy" }.to_owned()),
    ];
    let mut text = String::new();
    for (what, group) in kinds {
        let _ = writeln!(text, "\n## By {what}\n\nIndirect light.\n");
        let mut groups: BTreeMap<String, Vec<&RoomFigures>> = BTreeMap::new();
        for room in &figures.rooms {
            groups.entry(group(room)).or_default().push(room);
        }
        let mut rows = Vec::new();
        for (name, rooms) in &groups {
            for (number, method) in figures.methods.iter().enumerate() {
                let nrmse = percentiles(&values(rooms, &method.name, |e| Some(e.indirect.nrmse)), [0.5, 0.9, 1.0]);
                let bias = percentiles(&values(rooms, &method.name, |e| Some(e.indirect.bias.abs())), [0.5, 0.9, 1.0]);
                let (name, count) =
                    if number == 0 { (name.clone(), rooms.len().to_string()) } else { Default::default() };
                let cells = nrmse.into_iter().chain(bias).map(cell);
                rows.push([name, count, method.name.clone()].into_iter().chain(cells).collect());
            }
        }
        let head = [what, "count", "method", "nrmse: median", "90 %", "worst", "abs(bias): median", "90 %", "worst"];
        text += &markdown::table(&head, &rows);
    }
    text
}

fn worst(figures: &Figures) -> String {
    let mut text =
        "\n## The worst rooms\n\nBy nrmse of indirect light, with one standard error that the noise of the reference \
                    leaves open. Scenes open with `lightwell play FILE`; pictures \
                    show the indirect light of method and reference, and their difference.\n"
            .to_owned();
    for (index, method) in figures.methods.iter().enumerate() {
        let _ = writeln!(text, "\n### {}\n", method.name);
        let mut rows = Vec::new();
        for room in figures.worst(index, WORST) {
            let (error, facts) = (&room.errors[index], &room.facts);
            let limited = if room.reference.limited { " (limit)" } else { "" };
            rows.push(vec![
                format!("[{}]({})", facts.index, worst_scene(facts.index)),
                format!("{} + {}", markdown::error(error.indirect.nrmse), markdown::error(error.uncertainty)),
                markdown::signed(error.indirect.bias),
                markdown::error(error.total.nrmse),
                format!("{}{limited}", markdown::percent(room.reference.noise)),
                format!("[picture]({})", worst_picture(facts.index, &method.name)),
                facts.description.clone(),
            ]);
        }
        text += &markdown::table(&["room", "nrmse", "bias", "all light", "noise", "", ""], &rows);
    }
    text
}
