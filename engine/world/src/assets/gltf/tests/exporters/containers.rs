//! The text, the binary container, and files beside the model.

use super::*;

fn whole() -> Gltf {
    load_edited(&[]).unwrap()
}

/// Loads bytes of a file of this name.
fn load_bytes(name: &str, bytes: &[u8]) -> Result<Gltf, AssetError> {
    Gltf::from_bytes(Path::new(name), bytes)
}

#[test]
fn versions_and_generators() {
    check(vec![
        ("a version that is a number", vec![Set("/asset/version", "2.0")], Mended(&[], &["asset.version", "2.0"])),
        ("a version without a fraction", vec![Set("/asset/version", "\"2\"")], Mended(&[], &["asset.version", "2.0"])),
        ("a later version", vec![Set("/asset/version", "\"2.1\"")], Read(&[])),
        ("a version of the future", vec![Set("/asset/version", "\"3.0\"")], Refused(&["asset.version", "3.0"])),
        ("glTF 1.0", vec![Set("/asset/version", "1.0")], Refused(&["asset.version", "1.0"])),
        ("no asset", vec![Set("/asset", "null")], Refused(&["asset.version"])),
        ("a copyright that is none", vec![Set("/asset/copyright", "[]")], Mended(&[], &["asset, copyright"])),
        (
            "an extension that is needed and not known",
            vec![Set("/extensionsRequired", "[\"EXT_x\"]")],
            Refused(&["EXT_x"]),
        ),
        ("an extension that is used and not known", vec![Set("/extensionsUsed", "[\"EXT_x\"]")], Read(&[])),
    ]);
}

#[test]
fn texts_that_are_no_json() {
    let (root, bin) = edited(&[]);
    let whole = whole();
    let json = String::from_utf8(text(&root)).unwrap();
    for (from, to) in [
        (r#""x""#, r#""C:\Models\a""#),
        (r#""x""#, "\"a\tb\""),
        (r#""scene":0"#, r#""scene":0,"extras":{"a":[1,2,],}"#),
        (r#""scene":0"#, r#""scene":0,"extras":[nan,-inf,1.#QNAN,-nan(ind)]"#),
    ] {
        assert!(json.contains(from), "{from} is not in {json}");
        let text = json.replacen(from, to, 1);
        let model = load_bytes("a.glb", &glb(&[chunk(JSON, text.as_bytes()), chunk(BIN, &bin)])).unwrap();
        same(to, &model, &whole);
        says(to, &model, &["JSON does not allow"]);
    }
}

#[test]
fn binary_containers() {
    let (root, bin) = edited(&[]);
    let (whole, json) = (whole(), text(&root));
    let (first, second) = (chunk(JSON, &json), chunk(BIN, &bin));
    let body = [first.clone(), second.clone()].concat();
    let with_length = |length: usize| [header(length), body.clone()].concat();
    let other = chunk(0x1234_5678, &[1, 2, 3, 4]);
    let mut odd = json.clone();
    odd.extend(b"  ");
    let filled = [chunk(JSON, &odd), vec![b' '; 2], second.clone()].concat();
    let pair = || vec![first.clone(), second.clone()];
    for (name, bytes, words) in [
        ("a length of zero", with_length(0), &["GLB header", "length 0"][..]),
        ("a length without the header", with_length(body.len()), &["GLB header", "is wrong"]),
        ("a length beyond the end", with_length(99999), &["GLB header", "length 99999"]),
        ("zeros at the end", [glb(&pair()), vec![0; 5]].concat(), &[]),
        ("zeros that count", glb(&[pair(), vec![vec![0; 5]]].concat()), &["GLB chunk 2", "ignored"]),
        ("another chunk at the end", glb(&[pair(), vec![other.clone()]].concat()), &[]),
        ("another chunk between", glb(&[first.clone(), other, second.clone()]), &["GLB chunk 2", "must be the second"]),
        ("chunks in another order", glb(&[second.clone(), first.clone()]), &["GLB chunk 1", "must be the first"]),
        (
            "two binary chunks",
            glb(&[pair(), vec![chunk(BIN, &[0; 8])]].concat()),
            &["GLB chunk 2", "second of its kind"],
        ),
        ("two texts", glb(&[pair(), vec![chunk(JSON, b"{} ")]].concat()), &["GLB chunk 2", "second of its kind"]),
        (
            "a length that is no multiple of four",
            glb(&[chunk(JSON, &odd), second.clone()]),
            &["GLB chunk 0", "multiple of 4"],
        ),
        ("filling that does not count", glb(&[filled]), &["GLB chunk 0", "multiple of 4"]),
    ] {
        let model = load_bytes("a.glb", &bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        same(name, &model, &whole);
        match words.is_empty() {
            true => assert!(model.faults.is_empty(), "{name}: {:?}", model.faults),
            false => says(name, &model, words),
        }
    }
    same("another ending", &load_bytes("a.gltf", &glb(&pair())).unwrap(), &whole);
    for (name, bytes, word) in [
        ("no text", glb(std::slice::from_ref(&second)), "no JSON chunk"),
        ("an empty text", glb(&[chunk(JSON, &[]), second.clone()]), "empty"),
        ("a chunk that ends early", with_length(12 + body.len())[..body.len()].to_vec(), "beyond the end"),
        ("a header alone", header(12), "no JSON chunk"),
        ("half a header", b"glTF\x02\0".to_vec(), "within the header"),
        ("version 1", [words(&[0x4654_6C67, 1, 20]), vec![0; 8]].concat(), "version 1"),
        ("something else", b"PK\x03\x04".to_vec(), "no GLB"),
    ] {
        let message = load_bytes("a.glb", &bytes).map(|model| model.faults).expect_err(name).to_string();
        assert!(message.contains(word), "{name}: {message}");
    }
}

#[test]
fn buffers_of_binary_containers() {
    let (root, bin) = edited(&[]);
    let load_with = |edits: &[(&'static str, &'static str)]| {
        let mut root = root.clone();
        edits.iter().for_each(|(at, value)| set(&mut root, at, gltf::json::deserialize::from_str(value).unwrap()));
        load_bytes("folder/a.glb", &glb(&[chunk(JSON, &text(&root)), chunk(BIN, &bin)])).unwrap()
    };
    let whole = whole();
    let gone = load_with(&[("/buffers/0/uri", "\"gone.bin\"")]);
    same("a file that is not there", &gone, &whole);
    says("a file that is not there", &gone, &["gone.bin", "binary chunk"]);
    let empty = load_with(&[("/buffers/0/uri", "\"\"")]);
    same("an empty name", &empty, &whole);
    says("an empty name", &empty, &["buffer 0", "binary chunk"]);
    let length = root["buffers"][0]["byteLength"].to_string();
    let second: &'static str = Box::leak(format!(r#"{{"byteLength": {length}}}"#).into_boxed_str());
    let mut edits = vec![("/buffers/0", r#"{"byteLength": 1, "uri": "data:;base64,AA=="}"#), ("/buffers/-", second)];
    let views: Vec<&'static str> =
        (0..=IMAGE).map(|view| &*Box::leak(format!("/bufferViews/{view}/buffer").into_boxed_str())).collect();
    edits.extend(views.iter().map(|view| (*view, "1")));
    let later = load_with(&edits);
    same("a later buffer", &later, &whole);
    says("a later buffer", &later, &["buffer 1", "not the first"]);
}

/// Text under the name of a binary file.
#[test]
fn text_under_another_name() {
    let (root, bin) = edited(&[]);
    let mut root = root;
    let uri = format!("\"data:application/gltf-buffer;base64,{}\"", base64(&bin));
    set(&mut root, "/buffers/0/uri", gltf::json::deserialize::from_str(&uri).unwrap());
    let model = load_bytes("a.glb", root.to_string().as_bytes()).unwrap();
    same("text", &model, &whole());
    says("text", &model, &["GLB header", "JSON text"]);
    let plain = load_bytes("a.gltf", root.to_string().as_bytes()).unwrap();
    assert!(plain.faults.is_empty(), "{:?}", plain.faults);
}

/// Names of files as exporters write them lead to the files that they mean, and never out of the folder.
#[test]
fn names_of_files() {
    let outside = tempfile::tempdir().unwrap();
    let folder = outside.path().join("model");
    std::fs::create_dir_all(folder.join("Textures")).unwrap();
    let (root, bin) = edited(&[Set("/images/0/bufferView", "null"), Set("/images/0/uri", "\"\"")]);
    std::fs::write(folder.join("my buffer.bin"), &bin).unwrap();
    std::fs::write(folder.join("Textures/Wood 1.png"), png(3, 2)).unwrap();
    std::fs::write(outside.path().join("secret.png"), png(3, 2)).unwrap();
    let whole = whole();
    let load_with = |buffer: &str, image: &str| {
        let mut root = root.clone();
        (root["buffers"][0]["uri"], root["images"][0]["uri"]) = (Value::from(buffer), Value::from(image));
        let path = folder.join("a.gltf");
        std::fs::write(&path, root.to_string()).unwrap();
        Gltf::load(&path)
    };
    for (buffer, image, is_valid) in [
        ("my%20buffer.bin", "Textures/Wood%201.png", true),
        ("my buffer.bin", "./Textures/Wood 1.png", true),
        ("MY BUFFER.BIN", "textures/wood 1.PNG", false),
        ("my%20buffer.bin", "Textures\\Wood 1.png", false),
        ("my%20buffer.bin", "C:\\models\\room\\Textures\\Wood 1.png", false),
        ("D:/models/my%20buffer.bin", "file:///models/Textures/Wood%201.png", false),
        ("../model/my buffer.bin", "/models/Textures/Wood 1.png", false),
    ] {
        let model = load_with(buffer, image).unwrap_or_else(|error| panic!("{buffer} {image}: {error}"));
        same(image, &model, &whole);
        assert_eq!(model.faults.is_empty(), is_valid, "{:?}", model.faults);
        assert!(is_valid || model.faults.iter().any(|fault| fault.contains("leads to no file")), "{:?}", model.faults);
        assert!(model.files.iter().all(|file| file.starts_with(&folder)), "{:?}", model.files);
    }
    for image in ["../secret.png", "..\\secret.png", "https://example.org/Wood 1.png", "gone.png"] {
        let model = load_with("my buffer.bin", image).unwrap();
        assert!(model.nodes[0].primitives[0].1.base_color_texture.is_none(), "{image}");
        says(image, &model, &["image 0", "drawn without it"]);
    }
}
