//! Widgets of the inspector and entries of menus, by clicks.

use super::*;
use crate::comparison::Mode;
use egui::{Key, Modifiers, OutputCommand};
use lightwell::render::ToneMap;
use lightwell::render::debug::DebugView;
use lightwell::world::Light;

/// Rests the pointer on the text beside a field.
fn hover(bench: &mut Bench, label: &str) {
    let is_text = |node: &egui_kittest::Node| node.accesskit_node().role() == egui::accesskit::Role::Label;
    let at = bench.query_all_by_label(label).find(is_text).unwrap().rect().center();
    bench.hover_at(at);
    bench.run_steps(8);
}

fn tap(bench: &mut Bench, at: egui::Pos2) {
    bench.hover_at(at);
    bench.run_steps(1);
    bench.drag_at(at);
    bench.drop_at(at);
    bench.run_steps(3);
}

fn shows(bench: &Bench, text: &str) -> bool {
    bench.query_all_by_label_contains(text).next().is_some()
}

#[test]
fn rows_are_selected_together() {
    let (mut bench, _folder) = bench();
    let ids = ["Camera", "Lamp", "Group", "Mover"].map(|path| bench.state().id(path));
    click(&mut bench, "Lamp");
    find(&bench, "Mover").click_modifiers(Modifiers::COMMAND);
    bench.run_steps(3);
    assert_eq!(bench.state().editor.selection, [ids[1], ids[3]], "Ctrl adds");
    click(&mut bench, "Camera");
    find(&bench, "Group").click_modifiers(Modifiers::SHIFT);
    bench.run_steps(3);
    assert_eq!(bench.state().editor.selection, [ids[0], ids[1], ids[2]], "Shift takes all between");
    let before = bench.state().text();
    press(&mut bench, Modifiers::NONE, Key::Delete);
    assert_eq!(bench.state().world.roots().len(), 1);
    assert!(shows(&bench, "●"), "what is not saved is marked");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before, "one step");
    assert!(!shows(&bench, "●"));
}

#[test]
fn angles_colours_and_help_are_shown_as_they_are_meant() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Group");
    bench.run_steps(3);
    find(&bench, "Rotation y").focus();
    bench.run_steps(2);
    press(&mut bench, Modifiers::COMMAND, Key::A);
    bench.event(egui::Event::Text("30".into()));
    press(&mut bench, Modifiers::NONE, Key::Enter);
    let desk = bench.state();
    let turned = desk.world.rest_transform(desk.world.find("Group").unwrap()).rotation;
    assert!(turned.abs_diff_eq(glam::Quat::from_rotation_y(30_f32.to_radians()), 1e-5), "degrees: {turned}");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    hover(&mut bench, "Intensity");
    assert!(shows(&bench, "Intensity; unit by kind."), "help on hover");
    hover(&mut bench, "Shadow size");
    assert!(shows(&bench, "texels"), "with its unit");
    // The picker opens, with all its signs, and closes without a change.
    let before = bench.state().text();
    click(&mut bench, "Color picker");
    press(&mut bench, Modifiers::NONE, Key::Escape);
    assert_eq!(bench.state().text(), before);
    assert!(bench.state().editor.selection == [bench.state().id("Lamp")], "Escape closes the picker alone");
    // Numbers beside it are the same colour.
    let at = place_of(&bench, "Color y");
    drag(&mut bench, at, at - egui::vec2(60.0, 0.0));
    let desk = bench.state();
    let color = desk.world.ecs.get::<Light>(desk.world.find("Lamp").unwrap()).unwrap().color;
    assert!(color.y < 0.9 && color.x == 1.0, "{color}");
}

#[test]
fn files_are_picked_from_a_list() {
    let (mut bench, folder) = bench();
    std::fs::write(folder.path().join("cup.prefab.ron"), "Prefab(entities: [(name: \"Cup\", mesh: Cone())])").unwrap();
    std::fs::create_dir(folder.path().join("models")).unwrap();
    super::model::write_model(&folder.path().join("models"));
    bench.state_mut().select("Mover");
    bench.run_steps(3);
    click(&mut bench, "Add component");
    assert!(bench.query_by_label("Model").is_none(), "beside a mesh there is no model");
    press(&mut bench, Modifiers::NONE, Key::Escape);
    click(&mut bench, "Add");
    click(&mut bench, "Empty");
    click(&mut bench, "Add component");
    click(&mut bench, "Model");
    click(&mut bench, "models/tri.gltf");
    assert!(bench.state().world.find("Empty/Leaf").is_some());
    // The same list stands beside the name from then on.
    std::fs::create_dir(folder.path().join("other")).unwrap();
    super::model::write_model(&folder.path().join("other"));
    click(&mut bench, "…");
    click(&mut bench, "other/tri.gltf");
    assert!(bench.state().text().contains("other/tri.gltf"));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert!(bench.state().world.find("Empty/Leaf").is_none() && bench.state().world.find("Empty").is_some());
}

#[test]
fn entries_of_menus_do_what_they_say() {
    let (mut bench, folder) = bench();
    click(&mut bench, "File");
    click(&mut bench, "Rebuild shaders");
    assert_eq!(bench.state_mut().requests.pop(), Some(Request::RebuildShaders));
    click(&mut bench, "File");
    assert!(find(&bench, "Revert").accesskit_node().is_disabled(), "nothing to take back");
    press(&mut bench, Modifiers::NONE, Key::Escape);
    assert!(bench.query_by_label("Revert").is_none() && bench.state().requests.is_empty(), "Escape closes the menu");
    bench.state_mut().select("Lamp");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    click(&mut bench, "File");
    click(&mut bench, "Revert");
    assert!(bench.state().requests.is_empty() && shows(&bench, "There are changes that are not saved"));
    click(&mut bench, "Discard");
    assert_eq!(bench.state_mut().requests.pop(), Some(Request::Reload));
    let other = folder.path().join("other.scene.ron");
    bench.state_mut().editor.recent = vec![other.clone()];
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    click(&mut bench, "File");
    click(&mut bench, "Open recent");
    click(&mut bench, &other.display().to_string());
    assert_eq!(bench.state_mut().requests.pop(), Some(Request::Open(other)));
    // A prefab, and plain entities again.
    let file = folder.path().join("group.prefab.ron");
    bench.state_mut().select("Group");
    bench.state_mut().with_stage(|editor, stage| editor.make_prefab(stage, &file)).unwrap();
    bench.run_steps(2);
    assert!(bench.state().text().contains("prefab: "));
    click(&mut bench, "Edit");
    click(&mut bench, "Break the prefab");
    assert!(!bench.state().text().contains("prefab: "));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert!(bench.state().text().contains("prefab: "));
}

#[test]
fn every_debug_view_is_switched_on_and_off() {
    let (mut bench, _folder) = bench();
    click(&mut bench, "Debug");
    for view in DebugView::ALL {
        let name = view.name().replace('-', " ");
        click(&mut bench, &name);
        assert_eq!(bench.state().look.debug.views, [view]);
        click(&mut bench, &name);
        assert!(bench.state().look.debug.views.is_empty(), "{name}");
    }
}

#[test]
fn tone_map_and_settings_of_the_tracer_are_chosen() {
    let (mut bench, _folder) = bench();
    open(&mut bench, Pane::Display);
    click(&mut bench, "Tone map");
    click(&mut bench, "Filmic");
    assert_eq!(bench.state().display.tone_map, Some(ToneMap::Filmic));
    click(&mut bench, "Reset");
    assert_eq!(bench.state().display.tone_map, None);
    open(&mut bench, Pane::PathTracer);
    let before = bench.state().look.trace.clone();
    assert_eq!(before.bounces, None);
    click(&mut bench, "bounded");
    for name in ["Bounces", "Samples a pixel"] {
        let at = place_of(&bench, name);
        drag(&mut bench, at, at + egui::vec2(60.0, 0.0));
    }
    let now = &bench.state().look.trace;
    assert!(now.bounces > Some(3) && now.spp > before.spp, "{now:?}");
    click(&mut bench, "difference");
    assert_eq!(bench.state().comparison.mode, Mode::Difference);
}

#[test]
fn time_is_scrubbed_and_speed_changed() {
    let (mut bench, _folder) = bench();
    let slider = bench.query_all_by_role(egui::accesskit::Role::Slider).next().unwrap().rect();
    let text = bench.state().text();
    drag(&mut bench, slider.left_center() + egui::vec2(8.0, 0.0), slider.center());
    let seconds = bench.state().clock.seconds();
    assert!(seconds > 0.5 && !bench.state().clock.playing, "{seconds}");
    let desk = bench.state();
    let shown = desk.world.ecs.get::<lightwell::world::Transform>(desk.world.find("Mover").unwrap()).unwrap();
    assert!((f64::from(shown.translation.x) - seconds).abs() < 1e-3, "the scene follows: {shown:?}");
    press(&mut bench, Modifiers::NONE, Key::Plus);
    assert_eq!(bench.state().clock.speed(), 2.0);
    click(&mut bench, "Rewind");
    assert_eq!((bench.state().clock.seconds(), bench.state().text()), (0.0, text));
    assert!(!bench.state().editor.history.is_dirty());
}

#[test]
fn errors_are_copied_and_messages_filtered() {
    let (mut bench, _folder) = bench();
    let desk = bench.state_mut();
    desk.errors.push("geometry/gbuffer.wgsl:3:1: no such name".into());
    for text in ["a lamp is dark", "a wall is wet"] {
        desk.log.push(Record { level: log::Level::Info, target: "t".into(), text: text.into(), times: 1 });
    }
    open(&mut bench, Pane::Errors);
    find(&bench, "Copy").click();
    let mut copied = Vec::new();
    for _ in 0..3 {
        bench.run_steps(1);
        copied.extend(bench.output().platform_output.commands.clone());
    }
    let is_it =
        |c: &OutputCommand| matches!(c, OutputCommand::CopyText(text) if text.contains("geometry/gbuffer.wgsl:3:1"));
    assert!(copied.iter().any(is_it), "{copied:?}");
    open(&mut bench, Pane::Console);
    find(&bench, "Filter").focus();
    bench.run_steps(2);
    bench.event(egui::Event::Text("lamp".into()));
    bench.run_steps(3);
    assert!(shows(&bench, "a lamp is dark") && !shows(&bench, "a wall is wet"));
}

#[test]
fn a_profile_is_looked_into_and_written() {
    let (mut bench, folder) = bench();
    for name in ["aardvark", "zebra"] {
        bench.state_mut().profiler.frame(|frame| frame.span(name, |frame| frame.span("inner", |_| ())));
    }
    bench.state_mut().editor.panels.profiler.folder = folder.path().join("out");
    open(&mut bench, Pane::Profiler);
    assert!(shows(&bench, "zebra") && shows(&bench, "inner") && !shows(&bench, "aardvark"));
    // A bar a frame, the newest on the right.
    let bars = find(&bench, "Frames").rect();
    let width = bars.width() / lightwell::profile::FRAMES as f32;
    let at = bars.right_center() - egui::vec2(1.5 * width, 0.0);
    tap(&mut bench, at);
    assert!(shows(&bench, "aardvark") && !shows(&bench, "zebra"));
    click(&mut bench, "Export");
    let trace = std::fs::read_to_string(folder.path().join("out/profile.json")).unwrap();
    assert!(trace.contains("traceEvents") && trace.contains("aardvark") && trace.contains("zebra"));
}

#[test]
fn a_slice_of_a_target_is_shown_in_the_view() {
    use lightwell::graph::{ResourceReport, TextureDesc};
    let (mut bench, _folder) = bench();
    let mut desc = TextureDesc::d2(8, 8, wgpu::TextureFormat::Rgba32Float, wgpu::TextureUsages::TEXTURE_BINDING);
    (desc.size[2], desc.mips) = (6, 3);
    bench.state_mut().report.resources.push(ResourceReport {
        name: "cube".into(),
        desc: desc.into(),
        bytes: 32,
        aliased_with: Vec::new(),
        retained: true,
        imported: false,
    });
    open(&mut bench, Pane::Targets);
    click(&mut bench, "Target");
    click(&mut bench, "cube");
    for name in ["Mip level", "Slice"] {
        let at = place_of(&bench, name);
        drag(&mut bench, at, at + egui::vec2(300.0, 0.0));
    }
    let Some(Request::Target(choice)) = bench.state().requests.last().cloned() else { panic!("nothing is asked for") };
    assert_eq!((choice.name.as_str(), choice.mip, choice.layer), ("cube", 2, 5), "up to the last ones");
    let image = lightwell::gpu::ImageF32 { width: 1, height: 1, rgba: vec![[0.5, 0.25, 0.0, 1.0]] };
    bench.state_mut().editor.set_target(Ok(image));
    bench.run_steps(2);
    assert!(bench.state().editor.panels.targets.in_view().is_none());
    click(&mut bench, "in the view");
    assert!(bench.state().editor.panels.targets.in_view().is_some());
    click(&mut bench, "range");
    assert!(shows(&bench, "shown from 0.00000 to 0.50000"));
}

#[test]
fn work_behind_the_panels_shows() {
    let (mut bench, _folder) = bench();
    bench.state_mut().working.picture = Some((std::time::Duration::from_millis(100), (1, 40)));
    bench.run_steps(2);
    assert!(!shows(&bench, "drawing"), "what is done at once says nothing");
    bench.state_mut().working.picture = Some((std::time::Duration::from_secs(2), (12, 40)));
    bench.run_steps(2);
    assert!(shows(&bench, "drawing 12 of 40"));
    let said = "75 % of the size for 60 frames/s";
    assert!(!shows(&bench, said));
    bench.state_mut().budget = Some(said.to_owned());
    bench.run_steps(2);
    assert!(shows(&bench, said));
}
