//! Files broken at random: none may panic, hang or ask for more memory than they are worth. The seeds are fixed.
#![allow(clippy::unwrap_used)]

use super::Gltf;
use super::rig_tests::rigged;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::path::Path;
use std::time::{Duration, Instant};

/// A mutation of a file.
#[derive(Clone, Debug)]
enum Change {
    Flip(usize, u8),
    Overwrite(usize, Vec<u8>),
    Digit(usize, u8),
    Remove(usize, usize),
    Repeat(usize, usize),
}

fn change() -> impl Strategy<Value = Change> {
    let at = 0usize..1 << 16;
    prop_oneof![
        (at.clone(), any::<u8>()).prop_map(|(at, bits)| Change::Flip(at, bits)),
        (at.clone(), prop::collection::vec(any::<u8>(), 1..9)).prop_map(|(at, with)| Change::Overwrite(at, with)),
        (at.clone(), b'0'..=b'9').prop_map(|(at, digit)| Change::Digit(at, digit)),
        (at.clone(), 1usize..32).prop_map(|(at, length)| Change::Remove(at, length)),
        (at, 1usize..32).prop_map(|(at, length)| Change::Repeat(at, length)),
    ]
}

fn apply(bytes: &mut Vec<u8>, change: &Change) {
    let size = bytes.len().max(1);
    match change {
        Change::Flip(at, bits) => bytes[at % size] ^= bits,
        Change::Overwrite(at, with) => {
            let at = at % size;
            let end = (at + with.len()).min(size);
            bytes[at..end].copy_from_slice(&with[..end - at]);
        }
        // Numbers of the JSON text: sizes, indices and counts that still parse.
        Change::Digit(at, digit) => {
            let digits: Vec<usize> = (20..size).filter(|i| bytes[*i].is_ascii_digit()).collect();
            if let Some(i) = digits.get(at % digits.len().max(1)) {
                bytes[*i] = *digit;
            }
        }
        Change::Remove(at, length) => {
            let at = at % size;
            bytes.drain(at..(at + length).min(size));
            fit(bytes);
        }
        Change::Repeat(at, length) => {
            let at = at % size;
            let part = bytes[at..(at + length).min(size)].to_vec();
            bytes.splice(at..at, part);
            fit(bytes);
        }
    }
}

/// Makes the lengths in the headers those of the file again, so that more than the container is put to the test.
fn fit(bytes: &mut [u8]) {
    let total = bytes.len() as u32;
    let Some(bin) = bytes.windows(4).rposition(|w| w == b"BIN\0") else { return };
    if bytes.len() < 20 || bin < 28 {
        return;
    }
    bytes[8..12].copy_from_slice(&total.to_le_bytes());
    bytes[12..16].copy_from_slice(&(bin as u32 - 24).to_le_bytes());
    bytes[bin - 4..bin].copy_from_slice(&(total - bin as u32 - 4).to_le_bytes());
}

#[test]
fn files_broken_at_random_do_no_harm() {
    let (file, rest) = rigged();
    let whole = file.glb(&rest);
    assert!(Gltf::from_bytes(Path::new("test.glb"), &whole).is_ok());
    let config = Config { cases: 4000, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]));
    let (mut good, mut slowest) = (0, Duration::ZERO);
    let result = runner.run(&prop::collection::vec(change(), 1..4), |changes| {
        let mut bytes = whole.clone();
        changes.iter().for_each(|change| apply(&mut bytes, change));
        let start = Instant::now();
        let model = Gltf::from_bytes(Path::new("test.glb"), &bytes);
        let time = start.elapsed();
        prop_assert!(time < Duration::from_secs(2), "{time:?}");
        if let Ok(model) = model {
            for (mesh, _) in model.nodes.iter().flat_map(|node| &node.primitives) {
                prop_assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()));
            }
            model.clips.iter().flat_map(|c| c.nodes.values()).flat_map(|n| &n.translation).for_each(|c| {
                c.at(1.0);
            });
        }
        Ok(())
    });
    result.unwrap();
    // The same changes again, to say what they came to.
    let mut rng = TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[8; 32]));
    for _ in 0..500 {
        let changes = prop::collection::vec(change(), 1..4).new_tree(&mut rng).unwrap().current();
        let mut bytes = whole.clone();
        changes.iter().for_each(|change| apply(&mut bytes, change));
        let start = Instant::now();
        good += usize::from(Gltf::from_bytes(Path::new("test.glb"), &bytes).is_ok());
        slowest = slowest.max(start.elapsed());
    }
    eprintln!("of 500 broken files {good} load all the same; the slowest took {slowest:?}");
    assert!(good > 10 && good < 490, "the changes should neither all be harmless nor all be fatal: {good}");
}
