//! Edits of the settings of a frame, debug views among them.

use super::fields::names;
use glam::Vec3;
use lightwell::render::debug::{DebugView, Line};
use lightwell::render::reference::TraceSettings;
use lightwell::render::{Beside, Layer, MlaaEdges, ReferenceSettings, RenderSettings, Shown, UpdateRate};
use lightwell::world::ToneMap;

/// An edit of the settings, by the name of the field that it changes.
pub type Look = (&'static str, fn(&mut RenderSettings));

/// One sample a pixel: as many as a frame adds, so that frames do not depend on those before.
const ONE_SAMPLE: ReferenceSettings =
    ReferenceSettings { trace: TraceSettings { bounces: None, seed: 0 }, samples: 1, samples_a_frame: 1 };

fn toggle<T>(field: &mut Option<T>, value: T) {
    *field = if field.is_some() { None } else { Some(value) };
}

/// Edits of all fields but the method, most of which take turns between two states.
pub const LOOKS: [Look; 35] = [
    ("reference.trace.bounces", |s| toggle(&mut s.reference.trace.bounces, 1)),
    ("reference.trace.seed", |s| s.reference.trace.seed ^= 1),
    ("reference.samples", |s| {
        s.reference.samples ^= 3;
        s.reference.samples_a_frame = s.reference.samples;
    }),
    ("reference.samples_a_frame", |s| s.reference.samples_a_frame = 4),
    ("only", |s| s.only = if s.only == Layer::Albedo { Layer::Normal } else { Layer::Albedo }),
    ("only", |s| s.only = if s.only == Layer::Total { Layer::Depth } else { Layer::Total }),
    ("exposure", |s| s.exposure = 1.0 - s.exposure),
    ("auto_exposure", |s| s.auto_exposure = !s.auto_exposure),
    ("no_cache", |s| s.no_cache = !s.no_cache),
    ("each_light_alone", |s| s.each_light_alone = !s.each_light_alone),
    ("virtual_light", |s| toggle(&mut s.virtual_light, 1)),
    ("particle_paths", |s| s.particle_paths ^= 2),
    ("display", |s| s.display = !s.display),
    ("mlaa", |s| s.mlaa = !s.mlaa),
    ("mlaa_edges", |s| {
        s.mlaa = true;
        s.mlaa_edges = if s.mlaa_edges == MlaaEdges::Depth { MlaaEdges::Normal } else { MlaaEdges::Depth };
    }),
    ("mlaa_edges", |s| s.mlaa_edges = MlaaEdges::Color),
    ("show.tone_map", |s| toggle(&mut s.show.tone_map, ToneMap::Aces)),
    ("show.exposure", |s| s.show.exposure = 1.5 - s.show.exposure),
    ("show.auto_exposure", |s| s.show.auto_exposure = !s.show.auto_exposure),
    ("moment", |s| s.moment ^= 1),
    ("average", |s| s.average = !s.average),
    ("average", |s| s.average = true),
    ("images", |s| s.images ^= 5),
    ("gathered_at", |s| toggle(&mut s.gathered_at, [0.25, -0.25])),
    ("beside", |s| toggle(&mut s.beside, Beside { reference: ONE_SAMPLE, shown: Shown::Wipe(0.5) })),
    ("beside", |s| toggle(&mut s.beside, Beside { reference: ONE_SAMPLE, shown: Shown::Difference(0.5) })),
    ("update", |s| s.update = if s.update == UpdateRate::Whole { UpdateRate::Half } else { UpdateRate::Whole }),
    ("update", |s| {
        s.average = true;
        s.update = UpdateRate::Quarter;
    }),
    ("debug.cascade", |s| s.debug.cascade ^= 1),
    ("debug.bvh_level", |s| s.debug.bvh_level ^= 3),
    ("debug.outlined", |s| {
        s.debug.outlined = if s.debug.outlined.is_empty() { (0..64).collect() } else { Vec::new() };
    }),
    ("debug.lines", |s| {
        let line = |y| Line::new(Vec3::new(-1.0, y, 0.0), Vec3::new(1.0, y, 0.4), Vec3::new(1.0, 0.5, 0.2));
        s.debug.lines = match s.debug.lines.len() {
            0 => vec![line(0.5)],
            1 => vec![line(0.5), line(0.8).on_top()],
            _ => Vec::new(),
        };
    }),
    ("debug.targets", |s| {
        let targets = ["gbuffer depth=0..0.1", "radiance"].map(|text| text.parse().expect("a target"));
        s.debug.targets = if s.debug.targets.is_empty() { targets.into() } else { Vec::new() };
    }),
    ("debug.views", |s| s.debug.views.clear()),
    ("debug.views", |s| s.debug.views.extend([DebugView::Lights, DebugView::Light])),
];

/// Number of the first edit of a field.
pub fn number(name: &str) -> usize {
    LOOKS.iter().position(|(field, _)| *field == name).unwrap_or_else(|| panic!("no edit changes `{name}`"))
}

/// Turns a debug view on or off.
pub fn view(settings: &mut RenderSettings, view: usize) {
    let view = DebugView::ALL[view];
    if !settings.debug.views.remove(&view) {
        settings.debug.views.insert(view);
    }
}

/// Asserts that each field of a structure is edited, except those that are structures themselves.
fn assert_edited(path: &str, fields: &[String], structures: &[&str]) {
    for field in fields.iter().filter(|field| !structures.contains(&field.as_str())) {
        let path = format!("{path}{field}");
        assert!(LOOKS.iter().any(|(name, _)| *name == path), "no random edit changes `{path}`");
    }
}

#[test]
fn every_setting_of_a_frame_is_edited() {
    let settings = RenderSettings::default();
    // The method is an edit by itself.
    assert_edited("", &names(&settings), &["gi", "reference", "show", "debug"]);
    assert_edited("reference.", &names(&settings.reference), &["trace"]);
    assert_edited("reference.trace.", &names(&settings.reference.trace), &[]);
    assert_edited("show.", &names(&settings.show), &[]);
    assert_edited("debug.", &names(&settings.debug), &[]);
    for (name, edit) in LOOKS {
        let mut edited = settings.clone();
        edited.debug.views.insert(DebugView::Bvh);
        let before = edited.clone();
        edit(&mut edited);
        // One of the two edits restores the default.
        assert!(name == "mlaa_edges" || edited != before, "the edit of `{name}` does nothing");
    }
}
