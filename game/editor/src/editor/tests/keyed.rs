//! Fields that tracks change, in the inspector.

use super::*;
use egui::{Key, Modifiers};

#[test]
fn settings_and_volumes_that_are_keyed_are_edited_without_their_tracks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("keyed.scene.ron");
    let tracks = r#"tracks: [
        Keys(target: Field("scene.exposure"), keys: [(0, -2), (4, 2)]),
        Keys(target: Field("clpv.border_fade"), keys: [(0, 0), (4, 8)]),
        Keys("#;
    let scene = SCENE.replace("tracks: [\n                Keys(", tracks);
    let scene = scene.replace("mesh: Box(),", "mesh: Box(), clpv: (border_fade: 3),");
    std::fs::write(&path, scene.replace("duration: 4", "duration: 4, exposure: 0.5")).unwrap();
    let mut bench = bench_of(&path);
    bench.state_mut().clock.seek(1.0);
    bench.run_steps(2);
    let before = bench.state().text();
    let shown = |bench: &Bench| {
        let world = &bench.state().world;
        let clpv = world.ecs.get::<lightwell::world::Clpv>(world.find("Mover").unwrap()).unwrap();
        (world.ecs.resource::<SceneSettings>().exposure, clpv.border_fade)
    };
    assert_eq!(shown(&bench), (-1.0, 2.0));
    // To look at them, and to play, changes nothing.
    open(&mut bench, Pane::Scene);
    bench.state_mut().select("Mover");
    bench.run_steps(3);
    press(&mut bench, Modifiers::NONE, Key::Period);
    bench.state_mut().clock.seek(1.0);
    bench.run_steps(2);
    assert_eq!(bench.state().text(), before);
    assert!(!bench.state().editor.history.is_dirty());
    // An edit is of the value without the track, and can be undone.
    let at = place_of(&bench, "Exposure");
    drag(&mut bench, at, at + egui::vec2(50.0, 0.0));
    let own = bench.state().world.rest_settings().exposure;
    assert!(own > 0.55, "{own}");
    assert_eq!(shown(&bench), (-1.0, 2.0), "the track goes on");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
    let id = bench.state().id("Mover");
    let desk = bench.state_mut();
    let mut now = lightwell::files::describe_entity(&desk.world, desk.world.find("Mover").unwrap(), &path).unwrap();
    now.clpv.as_mut().unwrap().border_fade = 5.0;
    desk.with_stage(|editor, stage| editor.edit_components(stage, "change volume", &[(id, now.clone())])).unwrap();
    bench.run_steps(2);
    assert_eq!(shown(&bench), (-1.0, 2.0));
    assert!(bench.state().text().contains("border_fade: 5"), "{}", bench.state().text());
    // A track for a field that is not there is refused.
    let tracks = "(tracks:[Keys(target:Field(\"clpv.border\"),keys:[(0.0,1.0)])])";
    now.animation = Some(ron::from_str(tracks).unwrap());
    let desk = bench.state_mut();
    let error = desk.with_stage(|editor, stage| editor.edit_components(stage, "change", &[(id, now)])).unwrap_err();
    assert!(format!("{error:#}").contains("has no field `border`"), "{error:#}");
}
