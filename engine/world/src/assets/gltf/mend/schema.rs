//! The parts of the schema of glTF 2.0 that are read, as tables.

use gltf::json::Value;

/// What a value must be.
pub(super) enum Is {
    Flag,
    Text,
    /// One of some texts.
    Word(&'static [&'static str]),
    /// A number that a float can hold.
    Number,
    /// So many of them; none: any number.
    Numbers(Option<usize>),
    /// Four numbers of a colour, of which the last one may be missing.
    ColorAndAlpha,
    /// Bytes from one element to the next.
    Stride,
    /// A number without a fraction, of this range.
    Whole(u64, u64),
    /// One of some numbers.
    Code(&'static [u64]),
    /// The index of an element of a collection.
    To(&'static str),
    /// Indices of elements, all of which are needed.
    References(&'static str),
    /// Items of which any may be missing.
    Set(&'static Is),
    /// Items that others count: those that are broken become the stub.
    List {
        item: &'static Is,
        stub: &'static str,
    },
    /// Accessors by the names of attributes.
    Attributes,
    /// An object.
    Part(&'static [Field]),
}

/// Whether an object can do without a field.
pub(super) enum Need {
    /// It can: a broken one is as if it were not there.
    Optional,
    /// It must be there.
    Required,
    /// It may be missing, but a broken one breaks the object.
    Vital,
}

/// A field of an object.
pub(super) struct Field {
    pub name: &'static str,
    pub is: Is,
    pub need: Need,
}

/// A collection of elements that others refer to by number.
pub(super) struct Collection {
    pub name: &'static str,
    /// Names of the objects around it.
    pub within: &'static [&'static str],
    /// The name of an element in messages.
    pub one: &'static str,
    pub fields: &'static [Field],
    /// What stands for a broken element.
    pub stub: &'static str,
    /// What the fields cannot say one by one.
    pub check: fn(&mut Value) -> Result<(), String>,
}

/// Samplers of the animation at hand; those of textures are another collection.
pub(super) const ANIMATION_SAMPLERS: &str = "samplers of the animation";

/// The name of an element of a collection.
pub(super) fn one_of(collection: &str) -> &str {
    COLLECTIONS.iter().find(|other| other.name == collection).map_or("sampler", |other| other.one)
}

const fn optional(name: &'static str, is: Is) -> Field {
    Field { name, is, need: Need::Optional }
}

const fn required(name: &'static str, is: Is) -> Field {
    Field { name, is, need: Need::Required }
}

const fn vital(name: &'static str, is: Is) -> Field {
    Field { name, is, need: Need::Vital }
}

const NAME: Field = optional("name", Is::Text);
const ANY_OBJECT: Field = optional("extensions", Is::Part(&[]));
const BYTES: Is = Is::Whole(0, 1 << 53);

/// All collections, each after those that it refers to. Nodes are never broken, so that others may come before them.
pub(super) static COLLECTIONS: [Collection; 14] = [
    plain("buffers", "buffer", BUFFER, r#"{"byteLength":1,"uri":"data:;base64,AA=="}"#),
    plain("bufferViews", "buffer view", BUFFER_VIEW, r#"{"buffer":0,"byteLength":1}"#),
    plain("accessors", "accessor", ACCESSOR, r#"{"componentType":5121,"count":1,"type":"SCALAR"}"#),
    Collection { check: has_source, ..plain("images", "image", IMAGE, r#"{"uri":"data:;base64,"}"#) },
    plain("samplers", "sampler", SAMPLER, "{}"),
    plain("textures", "texture", TEXTURE, "{}"),
    plain("materials", "material", MATERIAL, "{}"),
    plain("meshes", "mesh", MESH, r#"{"primitives":[]}"#),
    Collection {
        check: has_projection,
        ..plain("cameras", "camera", CAMERA, r#"{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}"#)
    },
    Collection {
        within: &["extensions", "KHR_lights_punctual"],
        check: add_cone,
        ..plain("lights", "light", LIGHT, r#"{"type":"point","intensity":0}"#)
    },
    Collection { check: has_joints, ..plain("skins", "skin", SKIN, r#"{"joints":[]}"#) },
    plain("nodes", "node", NODE, "{}"),
    plain("animations", "animation", ANIMATION, r#"{"channels":[],"samplers":[]}"#),
    Collection { check: add_nodes, ..plain("scenes", "scene", SCENE, r#"{"nodes":[]}"#) },
];

const fn plain(name: &'static str, one: &'static str, fields: &'static [Field], stub: &'static str) -> Collection {
    Collection { name, within: &[], one, fields, stub, check: |_| Ok(()) }
}

/// The document itself; collections are looked at on their own.
pub(super) const ROOT: &[Field] = &[
    optional("extensionsUsed", Is::Set(&Is::Text)),
    optional("extensionsRequired", Is::Set(&Is::Text)),
    optional("scene", Is::To("scenes")),
    ANY_OBJECT,
    optional(
        "asset",
        Is::Part(&[
            optional("generator", Is::Text),
            optional("copyright", Is::Text),
            optional("minVersion", Is::Text),
            ANY_OBJECT,
        ]),
    ),
];

const BUFFER: &[Field] = &[required("byteLength", BYTES), vital("uri", Is::Text), NAME, ANY_OBJECT];

const BUFFER_VIEW: &[Field] = &[
    required("buffer", Is::To("buffers")),
    required("byteLength", BYTES),
    vital("byteOffset", BYTES),
    vital("byteStride", Is::Stride),
    optional("target", Is::Code(&[34962, 34963])),
    NAME,
    ANY_OBJECT,
];

const ACCESSOR: &[Field] = &[
    required("componentType", Is::Code(&[5120, 5121, 5122, 5123, 5125, 5126])),
    required("count", Is::Whole(1, 1 << 53)),
    required("type", Is::Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"])),
    vital("bufferView", Is::To("bufferViews")),
    vital("byteOffset", BYTES),
    optional("normalized", Is::Flag),
    optional("min", Is::Numbers(None)),
    optional("max", Is::Numbers(None)),
    vital(
        "sparse",
        Is::Part(&[
            required("count", Is::Whole(1, 1 << 53)),
            required(
                "indices",
                Is::Part(&[
                    required("bufferView", Is::To("bufferViews")),
                    required("componentType", Is::Code(&[5121, 5123, 5125])),
                    vital("byteOffset", BYTES),
                    ANY_OBJECT,
                ]),
            ),
            required(
                "values",
                Is::Part(&[required("bufferView", Is::To("bufferViews")), vital("byteOffset", BYTES), ANY_OBJECT]),
            ),
            ANY_OBJECT,
        ]),
    ),
    NAME,
    ANY_OBJECT,
];

const IMAGE: &[Field] = &[
    vital("uri", Is::Text),
    vital("bufferView", Is::To("bufferViews")),
    optional("mimeType", Is::Text),
    NAME,
    ANY_OBJECT,
];

const WRAPS: Is = Is::Code(&[33071, 33648, 10497]);

const SAMPLER: &[Field] = &[
    optional("magFilter", Is::Code(&[9728, 9729])),
    optional("minFilter", Is::Code(&[9728, 9729, 9984, 9985, 9986, 9987])),
    optional("wrapS", WRAPS),
    optional("wrapT", WRAPS),
    NAME,
    ANY_OBJECT,
];

const TEXTURE: &[Field] =
    &[optional("source", Is::To("images")), optional("sampler", Is::To("samplers")), NAME, ANY_OBJECT];

const SET: Is = Is::Whole(0, 255);
const FACTOR: Is = Is::Number;
const COLOR: Is = Is::Numbers(Some(3));

const INFO: &[Field] = &[required("index", Is::To("textures")), optional("texCoord", SET), INFO_EXTENSIONS];
const INFO_EXTENSIONS: Field = optional(
    "extensions",
    Is::Part(&[optional(
        "KHR_texture_transform",
        Is::Part(&[
            optional("offset", Is::Numbers(Some(2))),
            optional("rotation", Is::Number),
            optional("scale", Is::Numbers(Some(2))),
            optional("texCoord", SET),
        ]),
    )]),
);
const MAP: Is = Is::Part(INFO);
const NORMAL_MAP: Is = Is::Part(&[
    required("index", Is::To("textures")),
    optional("texCoord", SET),
    optional("scale", Is::Number),
    optional("strength", Is::Number),
    INFO_EXTENSIONS,
]);

const MATERIAL: &[Field] = &[
    optional(
        "pbrMetallicRoughness",
        Is::Part(&[
            optional("baseColorFactor", Is::ColorAndAlpha),
            optional("baseColorTexture", MAP),
            optional("metallicFactor", FACTOR),
            optional("roughnessFactor", FACTOR),
            optional("metallicRoughnessTexture", MAP),
            ANY_OBJECT,
        ]),
    ),
    optional("normalTexture", NORMAL_MAP),
    optional("occlusionTexture", NORMAL_MAP),
    optional("emissiveTexture", MAP),
    optional("emissiveFactor", COLOR),
    optional("alphaMode", Is::Word(&["OPAQUE", "MASK", "BLEND"])),
    optional("alphaCutoff", FACTOR),
    optional("doubleSided", Is::Flag),
    NAME,
    optional("extensions", Is::Part(MATERIAL_EXTENSIONS)),
];

const MATERIAL_EXTENSIONS: &[Field] = &[
    optional(
        "KHR_materials_anisotropy",
        Is::Part(&[
            optional("anisotropyStrength", FACTOR),
            optional("anisotropyRotation", FACTOR),
            optional("anisotropyTexture", MAP),
        ]),
    ),
    optional(
        "KHR_materials_clearcoat",
        Is::Part(&[
            optional("clearcoatFactor", FACTOR),
            optional("clearcoatTexture", MAP),
            optional("clearcoatRoughnessFactor", FACTOR),
            optional("clearcoatRoughnessTexture", MAP),
            optional("clearcoatNormalTexture", NORMAL_MAP),
        ]),
    ),
    optional("KHR_materials_dispersion", Is::Part(&[optional("dispersion", FACTOR)])),
    optional("KHR_materials_emissive_strength", Is::Part(&[optional("emissiveStrength", FACTOR)])),
    optional("KHR_materials_ior", Is::Part(&[optional("ior", FACTOR)])),
    optional(
        "KHR_materials_iridescence",
        Is::Part(&[
            optional("iridescenceFactor", FACTOR),
            optional("iridescenceTexture", MAP),
            optional("iridescenceIor", FACTOR),
            optional("iridescenceThicknessMinimum", FACTOR),
            optional("iridescenceThicknessMaximum", FACTOR),
            optional("iridescenceThicknessTexture", MAP),
        ]),
    ),
    optional(
        "KHR_materials_pbrSpecularGlossiness",
        Is::Part(&[
            optional("diffuseFactor", Is::ColorAndAlpha),
            optional("diffuseTexture", MAP),
            optional("specularFactor", COLOR),
            optional("glossinessFactor", FACTOR),
            optional("specularGlossinessTexture", MAP),
        ]),
    ),
    optional(
        "KHR_materials_sheen",
        Is::Part(&[
            optional("sheenColorFactor", COLOR),
            optional("sheenColorTexture", MAP),
            optional("sheenRoughnessFactor", FACTOR),
            optional("sheenRoughnessTexture", MAP),
        ]),
    ),
    optional(
        "KHR_materials_specular",
        Is::Part(&[
            optional("specularFactor", FACTOR),
            optional("specularTexture", MAP),
            optional("specularColorFactor", COLOR),
            optional("specularColorTexture", MAP),
        ]),
    ),
    optional(
        "KHR_materials_transmission",
        Is::Part(&[optional("transmissionFactor", FACTOR), optional("transmissionTexture", MAP)]),
    ),
    optional("KHR_materials_unlit", Is::Part(&[])),
    optional(
        "KHR_materials_volume",
        Is::Part(&[
            optional("thicknessFactor", FACTOR),
            optional("thicknessTexture", MAP),
            optional("attenuationDistance", FACTOR),
            optional("attenuationColor", COLOR),
        ]),
    ),
];

const MESH: &[Field] = &[
    NAME,
    required("primitives", Is::List { item: &Is::Part(PRIMITIVE), stub: r#"{"attributes":{}}"# }),
    optional("weights", Is::Numbers(None)),
    ANY_OBJECT,
];

const PRIMITIVE: &[Field] = &[
    required("attributes", Is::Attributes),
    vital("indices", Is::To("accessors")),
    optional("material", Is::To("materials")),
    vital("mode", Is::Code(&[0, 1, 2, 3, 4, 5, 6])),
    optional("targets", Is::List { item: &Is::Attributes, stub: "{}" }),
    ANY_OBJECT,
];

const CAMERA: &[Field] = &[
    required("type", Is::Word(&["perspective", "orthographic"])),
    vital(
        "perspective",
        Is::Part(&[
            required("yfov", Is::Number),
            required("znear", Is::Number),
            optional("zfar", Is::Number),
            optional("aspectRatio", Is::Number),
            ANY_OBJECT,
        ]),
    ),
    vital(
        "orthographic",
        Is::Part(&[
            required("xmag", Is::Number),
            required("ymag", Is::Number),
            required("znear", Is::Number),
            required("zfar", Is::Number),
            ANY_OBJECT,
        ]),
    ),
    NAME,
    ANY_OBJECT,
];

const LIGHT: &[Field] = &[
    required("type", Is::Word(&["directional", "point", "spot"])),
    optional("color", COLOR),
    vital("intensity", Is::Number),
    optional("range", Is::Number),
    optional(
        "spot",
        Is::Part(&[optional("innerConeAngle", Is::Number), optional("outerConeAngle", Is::Number), ANY_OBJECT]),
    ),
    NAME,
    ANY_OBJECT,
];

const SKIN: &[Field] = &[
    required("joints", Is::References("nodes")),
    optional("inverseBindMatrices", Is::To("accessors")),
    optional("skeleton", Is::To("nodes")),
    NAME,
    ANY_OBJECT,
];

const NODE: &[Field] = &[
    NAME,
    optional("children", Is::Set(&Is::To("nodes"))),
    optional("camera", Is::To("cameras")),
    optional("mesh", Is::To("meshes")),
    optional("skin", Is::To("skins")),
    optional("matrix", Is::Numbers(Some(16))),
    optional("translation", Is::Numbers(Some(3))),
    optional("rotation", Is::Numbers(Some(4))),
    optional("scale", Is::Numbers(Some(3))),
    optional("weights", Is::Numbers(None)),
    optional(
        "extensions",
        Is::Part(&[optional("KHR_lights_punctual", Is::Part(&[required("light", Is::To("lights"))]))]),
    ),
];

pub(super) const ANIMATION_SAMPLER: &[Field] = &[
    required("input", Is::To("accessors")),
    required("output", Is::To("accessors")),
    optional("interpolation", Is::Word(&["LINEAR", "STEP", "CUBICSPLINE"])),
    ANY_OBJECT,
];

const ANIMATION: &[Field] = &[NAME, required("channels", Is::Set(&Is::Part(CHANNEL))), ANY_OBJECT];

const CHANNEL: &[Field] = &[
    required("sampler", Is::To(ANIMATION_SAMPLERS)),
    required(
        "target",
        Is::Part(&[
            required("node", Is::To("nodes")),
            required("path", Is::Word(&["translation", "rotation", "scale", "weights"])),
            ANY_OBJECT,
        ]),
    ),
    ANY_OBJECT,
];

const SCENE: &[Field] = &[NAME, optional("nodes", Is::Set(&Is::To("nodes"))), ANY_OBJECT];

fn has_source(image: &mut Value) -> Result<(), String> {
    match image.get("uri").or(image.get("bufferView")) {
        Some(_) => Ok(()),
        None => Err(": has neither a URI nor a buffer view".into()),
    }
}

fn has_projection(camera: &mut Value) -> Result<(), String> {
    let kind = camera.get("type").and_then(Value::as_str).unwrap_or_default();
    match camera.get(kind) {
        Some(_) => Ok(()),
        None => Err(format!(": has no `{kind}`, which its type asks for")),
    }
}

/// A spot without its cone has the default one.
fn add_cone(light: &mut Value) -> Result<(), String> {
    let is_spot = light.get("type").and_then(Value::as_str) == Some("spot");
    if let Some(light) = light.as_object_mut().filter(|light| is_spot && !light.contains_key("spot")) {
        light.insert("spot".into(), Value::Object(Default::default()));
    }
    Ok(())
}

/// A scene may be without nodes, which the parser does not know.
fn add_nodes(scene: &mut Value) -> Result<(), String> {
    if let Some(scene) = scene.as_object_mut().filter(|scene| !scene.contains_key("nodes")) {
        scene.insert("nodes".into(), Value::Array(Vec::new()));
    }
    Ok(())
}

fn has_joints(skin: &mut Value) -> Result<(), String> {
    match skin.get("joints").and_then(Value::as_array).is_some_and(|joints| !joints.is_empty()) {
        true => Ok(()),
        false => Err(": has no joints".into()),
    }
}
