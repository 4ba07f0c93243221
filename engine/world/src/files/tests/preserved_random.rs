//! Random edits of random texts with comments anywhere: the text means what was to be saved, and what was not edited
//! stays.

use super::round_trip::{entity, unique};
use super::*;
use crate::files::ron::scan::strings;
use crate::files::ron::tree::{Node, Step};
use crate::files::save::rewrite::rewritten;
use crate::files::save::text::to_text;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

/// A text with comments behind some of its commas and brackets.
fn commented(text: &str, picks: &[(Index, u8)]) -> String {
    let strings = strings(text);
    let is_free = |at: &usize| !strings.iter().any(|string| string.contains(at));
    let places: Vec<usize> = text.match_indices(['(', '[', '{', ',']).map(|(at, _)| at).filter(is_free).collect();
    let mut chosen: Vec<(usize, u8)> =
        picks.iter().map(|(pick, kind)| (places[pick.index(places.len())] + 1, *kind)).collect();
    chosen.sort_unstable();
    let mut out = String::new();
    let mut at = 0;
    for (number, (place, kind)) in chosen.into_iter().enumerate() {
        out.push_str(&text[at..place]);
        out.push_str(&match kind % 5 {
            0 => format!(" /* {number} ( */"),
            1 => format!(" // {number}, \"\n"),
            2 => format!("\n    // {number}\n    // more of it ]\n"),
            3 => format!("\n\n /* {number}\n /* inner */ */\n\n"),
            _ => "\r\n\t".to_owned(),
        });
        at = place;
    }
    out + &text[at..]
}

/// An edit of one entity, or of the list of all.
#[derive(Clone, Debug)]
enum Edit {
    Change(Index, Box<EntityFile>),
    Remove(Index),
    Insert(Index, Box<EntityFile>),
    Move(Index, Index),
    Into(Index, Index),
    Rename(Index, String),
}

fn edit() -> impl Strategy<Value = Edit> {
    let index = any::<Index>;
    prop_oneof![
        (index(), entity()).prop_map(|(at, new)| Edit::Change(at, Box::new(new))),
        index().prop_map(Edit::Remove),
        (index(), entity()).prop_map(|(at, new)| Edit::Insert(at, Box::new(new))),
        (index(), index()).prop_map(|(from, to)| Edit::Move(from, to)),
        (index(), index()).prop_map(|(from, to)| Edit::Into(from, to)),
        (index(), "[a-z]{1,8}").prop_map(|(at, name)| Edit::Rename(at, name)),
    ]
}

fn apply(entities: &mut Vec<EntityFile>, edit: &Edit) {
    let count = entities.len();
    match edit {
        Edit::Insert(at, new) => entities.insert(at.index(count + 1), (**new).clone()),
        _ if count == 0 => {}
        Edit::Change(at, new) => {
            let entity = &mut entities[at.index(count)];
            entity.transform = new.transform;
            entity.light.clone_from(&new.light);
            entity.camera.clone_from(&new.camera);
        }
        Edit::Remove(at) => drop(entities.remove(at.index(count))),
        Edit::Move(from, to) => {
            let entity = entities.remove(from.index(count));
            entities.insert(to.index(count), entity);
        }
        Edit::Into(from, to) if count > 1 => {
            let entity = entities.remove(from.index(count));
            entities[to.index(count - 1)].children.push(entity);
        }
        Edit::Into(..) => {}
        Edit::Rename(at, name) => entities[at.index(count)].name.clone_from(name),
    }
}

fn scene(entities: Vec<EntityFile>) -> SceneFile {
    let materials = [("a \"b\" \\ ü".to_owned(), MaterialFile::default())].into();
    SceneFile { materials, entities, ..Default::default() }
}

fn parsed(text: &str) -> SceneFile {
    Document::parse::<SceneFile>(Path::new("a.scene.ron"), text.to_owned()).unwrap_or_else(|e| panic!("{e}\n{text}")).1
}

fn rewrite(text: &str, wanted: &SceneFile) -> Option<String> {
    rewritten(text, Path::new("a.scene.ron"), wanted, &ComponentTypes::default())
}

/// The text of each entity.
fn entity_texts(text: &str) -> Vec<&str> {
    let tree = Node::parse(text);
    let list = Step::Key("entities".into());
    let texts =
        (0..parsed(text).entities.len()).map(|index| tree.find(&[list.clone(), Step::Index(index)]).span.clone());
    texts.map(|span| &text[span]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_was_to_be_saved_is_what_the_text_means(
        entities in vec(entity(), 0..5),
        picks in vec((any::<Index>(), any::<u8>()), 0..20),
        edits in vec(edit(), 0..4),
    ) {
        let text = commented(&to_text(&scene(unique(entities)), None).unwrap(), &picks);
        let mut wanted = parsed(&text);
        prop_assert_eq!(rewrite(&text, &wanted), Some(text.clone()));
        edits.iter().for_each(|edit| apply(&mut wanted.entities, edit));
        wanted.entities = unique(wanted.entities);
        let after = rewrite(&text, &wanted);
        prop_assert!(after.is_some(), "{}", text);
        prop_assert_eq!(parsed(&after.unwrap_or_default()), wanted);
    }

    #[test]
    fn what_was_not_edited_stays(
        entities in vec(entity(), 1..6),
        picks in vec((any::<Index>(), any::<u8>()), 0..20),
        edit in edit(),
    ) {
        let text = commented(&to_text(&scene(unique(entities)), None).unwrap(), &picks);
        let before = parsed(&text);
        let mut wanted = before.clone();
        apply(&mut wanted.entities, &edit);
        wanted.entities = unique(wanted.entities);
        let after = rewrite(&text, &wanted).unwrap_or_default();
        let texts = entity_texts(&text);
        for (entity, own) in before.entities.iter().zip(&texts) {
            if wanted.entities.contains(entity) {
                prop_assert!(after.contains(own), "{}\n---\n{}", own, after);
            }
        }
        if let Edit::Change(at, _) = edit {
            let at = at.index(texts.len());
            let start = texts[at].as_ptr() as usize - text.as_ptr() as usize;
            prop_assert!(after.starts_with(&text[..start]) && after.ends_with(&text[start + texts[at].len()..]), "{}", after);
        }
    }
}
