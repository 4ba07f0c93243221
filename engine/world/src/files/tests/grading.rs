//! Colour tables of cameras: found beside the file that names them, refused with line and column, and rewritten.

use super::*;
use crate::assets::CubeTable;
use crate::world::{Camera, GradingTable};

fn table(last: &str) -> String {
    format!("TITLE \"t\"\nLUT_3D_SIZE 2\n{}{last}\n", "0 0 0\n".repeat(7))
}

const CAMERA: &str = "(name: \"Eye\", camera: (lens: (grading: \"looks/warm.cube\")))";

fn scene(entity: &str) -> String {
    format!("Scene(entities: [\n  {entity},\n])")
}

fn loaded<'a>(world: &'a GameWorld, path: &str) -> (&'a Camera, &'a GradingTable) {
    let entity = at(world, path).unwrap();
    (world.ecs.get(entity).unwrap(), world.ecs.get(entity).unwrap())
}

#[test]
fn a_table_lies_beside_the_file_that_names_it() {
    let prefab = format!("Prefab(entities: [{CAMERA}])");
    let folder = Folder::new(&[
        ("a.scene.ron", &scene(&format!("{CAMERA}, (name: \"P\", prefab: \"parts/p.prefab.ron\")"))),
        ("parts/p.prefab.ron", &prefab),
        ("looks/warm.cube", &table("1 0.5 0.25")),
        ("parts/looks/warm.cube", &table("0 1 0")),
    ]);
    let world = folder.load("a.scene.ron").unwrap_or_else(|error| panic!("{error}"));
    let (camera, found) = loaded(&world, "Eye");
    assert_eq!(camera.lens.grading.as_ref(), Some(&found.file));
    assert_eq!(found.table.entries[7], glam::Vec3::new(1.0, 0.5, 0.25));
    // The prefab's lies beside the prefab.
    let (camera, found) = loaded(&world, "P/Eye");
    assert_eq!(camera.lens.grading.as_ref(), Some(&found.file));
    assert_eq!(found.table.entries[7], glam::Vec3::Y);
    // What was not changed is not saved as an override.
    let text = crate::files::save::scene::scene_text(&world, &folder.path("a.scene.ron")).unwrap();
    assert!(text.contains("looks/warm.cube") && !text.contains("overrides"), "{text}");
}

#[test]
fn faults_name_the_scene_and_the_line_of_the_table() {
    for (text, kind, part) in [
        (Some(table("1 x 0")), FileErrorKind::Asset, "line 10"),
        (Some("LUT_1D_SIZE 4\n".into()), FileErrorKind::Asset, "one dimension"),
        (None, FileErrorKind::MissingFile, "looks/warm.cube"),
    ] {
        let folder = Folder::new(&[("a.scene.ron", &scene(CAMERA))]);
        if let Some(text) = text {
            folder.write("looks/warm.cube", text.as_bytes());
        }
        let error = folder.load("a.scene.ron").err().unwrap();
        assert!(error.kind == kind && error.to_string().contains(part), "{error}");
        assert_eq!(error.place.map(|place| place.line), Some(2), "{error}");
    }
}

#[test]
fn a_table_outside_of_the_project_is_refused_until_it_is_trusted() {
    let folder = Folder::new(&[
        ("game/a.scene.ron", &scene(&CAMERA.replace("looks", "../looks"))),
        ("looks/warm.cube", &table("1 1 1")),
    ]);
    let error = folder.load("game/a.scene.ron").err().unwrap();
    assert_eq!(error.kind, FileErrorKind::Untrusted, "{error}");
    let options = LoadOptions { trusted: vec![folder.path("")], ..Default::default() };
    load_scene(&folder.path("game/a.scene.ron"), &mut AssetLibrary::new(), &options).unwrap();
}

#[test]
fn edits_load_another_table_and_saves_elsewhere_find_it_again() {
    let folder = Folder::new(&[
        ("a.scene.ron", &scene(CAMERA)),
        ("looks/warm.cube", &table("1 0 0")),
        ("looks/cold.cube", &table("0 0 1")),
        ("deep/b.txt", ""),
    ]);
    let (path, options, mut library) = (folder.path("a.scene.ron"), LoadOptions::default(), AssetLibrary::new());
    let mut world = load_scene(&path, &mut library, &options).unwrap();
    let entity = at(&world, "Eye").unwrap();
    let mut edit = |world: &mut GameWorld, file: &str| {
        let mut now = describe_entity(world, entity, &path).unwrap();
        now.camera.as_mut().unwrap().lens.grading = Some(file.to_owned());
        let mut context = EditContext { library: &mut library, options: &options, path: &path };
        edit_entity(world, &mut context, entity, &now)
    };
    assert!(edit(&mut world, "looks/none.cube").is_err());
    assert_eq!(loaded(&world, "Eye").0.lens.grading.as_deref(), Some("looks/warm.cube"), "nothing was changed");
    edit(&mut world, "looks/cold.cube").unwrap();
    assert_eq!(loaded(&world, "Eye").1.table.entries[7], glam::Vec3::Z);
    let to = folder.path("deep/b.scene.ron");
    let trusted = LoadOptions { trusted: vec![folder.path("")], ..Default::default() };
    save_scene_as(&mut world, &AssetLibrary::new(), &trusted, &path, &to).unwrap();
    assert_eq!(loaded(&world, "Eye").1.file, "../looks/cold.cube");
    let again = load_scene(&to, &mut AssetLibrary::new(), &trusted).unwrap();
    assert_eq!(loaded(&again, "Eye").1.table.entries[7], glam::Vec3::Z);
    assert_ne!(CubeTable::identity(2), CubeTable::identity(2), "each table has an identity of its own");
}
