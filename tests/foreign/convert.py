"""Converts a Mitsuba 0.6 scene of OBJ and .serialized meshes, made diffuse: python convert.py SCENE.xml OUT_FOLDER NAME

Writes NAME.glb and NAME.scene.ron for Lightwell, and NAME.npz for mitsuba3.py, with the same triangles. Every surface reflects
diffusely and on both sides, with the mean colour of its texture; metals have a reflectance of 0.6. Area emitters keep their
radiance. A sky, an environment map or a sun becomes an even sky of radiance 1. Glass and shapes whose file is missing are left out on
both sides; the command says which. Needs numpy and Pillow.
"""

import json
import struct
import sys
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

import numpy as np
from PIL import Image

METAL = 0.6
UNKNOWN = 0.5
LEAST, MOST = 0.02, 0.9
GLASS = {"dielectric", "roughdielectric", "thindielectric"}
SKIES = {"sunsky", "sky", "sun", "envmap", "constant"}


def numbers(text):
    return np.array([float(word) for word in text.replace(",", " ").split()])


def transform(element):
    """The matrix of a <transform>: its parts apply one after the other."""
    matrix = np.eye(4)
    for part in element if element is not None else []:
        kind, step = part.tag.lower(), np.eye(4)
        if kind == "matrix":
            step = numbers(part.get("value")).reshape(4, 4)
        elif kind == "translate":
            step[:3, 3] = [float(part.get(axis, 0)) for axis in "xyz"]
        elif kind == "scale":
            even = float(part.get("value", 1))
            step[:3, :3] = np.diag([float(part.get(axis, even)) for axis in "xyz"])
        elif kind == "rotate":
            axis = np.array([float(part.get(name, 0)) for name in "xyz"])
            step[:3, :3] = rotation(axis / np.linalg.norm(axis), np.radians(float(part.get("angle"))))
        elif kind == "lookat":
            step = look_at(*(numbers(part.get(name)) for name in ("origin", "target", "up")))
        matrix = step @ matrix
    return matrix


def rotation(axis, angle):
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def look_at(origin, target, up):
    forward = (target - origin) / np.linalg.norm(target - origin)
    left = np.cross(up, forward)
    left /= np.linalg.norm(left)
    matrix = np.eye(4)
    matrix[:3] = np.stack([left, np.cross(forward, left), forward, origin], 1)
    return matrix


class Surfaces:
    """The reflectance of BSDFs, and which of them are glass."""

    def __init__(self, root, folder):
        self.folder = folder
        self.textures = {item.get("id"): item for item in root.findall("texture")}
        self.named = {item.get("id"): item for item in root.findall("bsdf")}

    def of(self, shape):
        """The BSDF of a shape, or None."""
        names = [item.get("id") for item in shape.findall("ref")]
        found = [self.named[name] for name in names if name in self.named]
        return (shape.findall("bsdf") + found + [None])[0]

    def is_glass(self, bsdf):
        return bsdf is not None and any(item.get("type") in GLASS for item in bsdf.iter("bsdf"))

    def reflectance(self, bsdf):
        if bsdf is None:
            return np.full(3, UNKNOWN)
        for name in ("reflectance", "diffuseReflectance"):
            for item in bsdf.iter():
                if item.get("name") == name:
                    return np.clip(self.color(item), LEAST, MOST)
        is_metal = any("conductor" in item.get("type") for item in bsdf.iter("bsdf"))
        return np.full(3, METAL if is_metal else UNKNOWN)

    def color(self, item):
        if item.tag in ("rgb", "srgb", "spectrum") and ":" not in item.get("value"):
            value = item.get("value")
            if value.startswith("#"):
                return (np.array([int(value[i : i + 2], 16) for i in (1, 3, 5)]) / 255) ** 2.2
            value = np.resize(numbers(value), 3)
            return value**2.2 if item.tag == "srgb" else value
        texture = self.textures.get(item.get("id"), item)
        file = texture.find("string[@name='filename']")
        if file is not None and (self.folder / file.get("value")).exists():
            pixels = np.asarray(Image.open(self.folder / file.get("value")).convert("RGB")) / 255
            return (pixels**2.2).mean((0, 1))
        return np.full(3, UNKNOWN)


def read_obj(path):
    """Triangles (n, 3, 3), turned as the normals of the file are."""
    points, normals, corners, sides = [], [], [], []
    for line in path.read_text(errors="replace").splitlines():
        if line.startswith("v "):
            points.append(line.split()[1:4])
        elif line.startswith("vn "):
            normals.append(line.split()[1:4])
        elif line.startswith("f "):
            words = [word.split("/") for word in line.split()[1:]]
            at = [index(word[0], points) for word in words]
            side = index(words[0][2], normals) if len(words[0]) > 2 and words[0][2] else -1
            corners += [[at[0], at[i], at[i + 1]] for i in range(1, len(at) - 1)]
            sides += [side] * (len(at) - 2)
    if not corners:
        return np.zeros((0, 3, 3))
    triangles = np.array(points, float)[np.array(corners)]
    return turned(triangles, np.array(normals or [[0, 0, 0]], float)[np.array(sides)], np.array(sides) >= 0)


def index(word, of):
    value = int(word)
    return value - 1 if value > 0 else len(of) + value


def turned(triangles, normals, known):
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    wrong = known & ((cross * normals).sum(-1) < 0)
    triangles[wrong] = triangles[wrong][:, ::-1]
    return triangles


def read_serialized(path, number):
    """Triangles of one of the meshes of a file (Mitsuba 0.6 manual, section 8.1.4)."""
    data = path.read_bytes()
    version = struct.unpack_from("<H", data, 2)[0]
    count = struct.unpack_from("<I", data, len(data) - 4)[0]
    width = 8 if version > 3 else 4
    start = struct.unpack_from("<Q" if width == 8 else "<I", data, len(data) - 4 - width * (count - number))[0]
    mesh = zlib.decompressobj().decompress(data[start + 4 :])
    flags = struct.unpack_from("<I", mesh)[0]
    at = 4 if version < 4 else mesh.index(b"\0", 4) + 1
    vertices, faces = struct.unpack_from("<QQ", mesh, at)
    real = np.dtype("<f8" if flags & 0x2000 else "<f4")
    at += 16
    points = np.frombuffer(mesh, real, 3 * vertices, at).reshape(-1, 3)
    # Normals, texture coordinates and colours.
    at += real.itemsize * vertices * (3 + 3 * bool(flags & 1) + 2 * bool(flags & 2) + 3 * bool(flags & 8))
    corners = np.frombuffer(mesh, "<u4", 3 * faces, at).reshape(-1, 3)
    return points[corners].astype(float)


def read_shape(shape, folder):
    """Triangles in world space; None if the file is missing or the kind is another."""
    kind = shape.get("type")
    file = shape.find("string[@name='filename']")
    if kind == "rectangle":
        square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
        triangles = square[[[0, 1, 2], [0, 2, 3]]]
    elif file is None or not (folder / file.get("value")).exists() or kind not in ("obj", "serialized"):
        return None
    elif kind == "obj":
        triangles = read_obj(folder / file.get("value"))
    else:
        number = shape.find("integer[@name='shapeIndex']")
        triangles = read_serialized(folder / file.get("value"), int(number.get("value")) if number is not None else 0)
    matrix = transform(shape.find("transform"))
    triangles = triangles @ matrix[:3, :3].T + matrix[:3, 3]
    return triangles[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else triangles


def parts(root, folder):
    """Triangles by (reflectance, radiance), and what is left out."""
    surfaces, found, left_out = Surfaces(root, folder), {}, []
    for shape in root.findall("shape"):
        bsdf, emitter = surfaces.of(shape), shape.find("emitter")
        name = shape.find("string[@name='filename']")
        name = shape.get("type") if name is None else name.get("value")
        if surfaces.is_glass(bsdf) and emitter is None:
            left_out.append(name + " (glass)")
            continue
        triangles = read_shape(shape, folder)
        if triangles is None:
            left_out.append(name)
            continue
        radiance = np.zeros(3) if emitter is None else surfaces.color(emitter.find("*[@name='radiance']"))
        reflectance = np.zeros(3) if emitter is not None else surfaces.reflectance(bsdf)
        key = tuple(np.round(reflectance, 3)), tuple(np.round(radiance, 3))
        found.setdefault(key, []).append(triangles)
    return {key: clean(np.concatenate(triangles)) for key, triangles in found.items()}, left_out


def clean(triangles):
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return triangles[np.linalg.norm(cross, axis=1) > 1e-12].astype(np.float32)


def write_glb(path, materials):
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
    document |= {"meshes": [{"primitives": []}], "materials": [], "accessors": [], "bufferViews": []}
    document["extensionsUsed"] = ["KHR_materials_specular", "KHR_materials_emissive_strength"]
    data = b""
    for number, ((reflectance, radiance), triangles) in enumerate(materials.items()):
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        arrays = {"POSITION": triangles.reshape(-1, 3), "NORMAL": normals.repeat(3, 0).astype(np.float32)}
        attributes = {}
        for name, array in arrays.items():
            attributes[name] = len(document["accessors"])
            document["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
            accessor = {"bufferView": attributes[name], "componentType": 5126, "count": len(array), "type": "VEC3"}
            if name == "POSITION":
                accessor |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
            document["accessors"].append(accessor)
            data += array.tobytes()
        document["meshes"][0]["primitives"].append({"attributes": attributes, "material": number})
        document["materials"].append(material(reflectance, radiance))
    document["buffers"] = [{"byteLength": len(data)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
    path.write_bytes(head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def material(reflectance, radiance):
    strength = float(max(radiance))
    found = {"pbrMetallicRoughness": {"baseColorFactor": [*map(float, reflectance), 1.0], "metallicFactor": 0}}
    found |= {"doubleSided": bool(strength == 0), "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}
    if strength > 0:
        found["emissiveFactor"] = [float(value / strength) for value in radiance]
        found["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": float(strength)}
    return found


def angles(camera):
    """Degrees about x, y and z of a scene file: the turn about z comes first, then x, then y. It looks along -z, x to the right."""
    right, up, back = -camera[:3, 0], camera[:3, 1], -camera[:3, 2]
    return np.degrees([np.arcsin(-back[1]), np.arctan2(back[0], back[2]), np.arctan2(right[1], up[1])])


SCENE = """Scene(settings: (sky: ({sky}, {sky}, {sky})), entities: [
    (name: "Camera", transform: (translation: {eye}, rotation: {rotation}), camera: (fov: {fov}, near: {near})),
    (name: "Room", model: "{name}.glb"),
])
"""


def main():
    path, out, name = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    root = ElementTree.parse(path).getroot()
    materials, left_out = parts(root, path.parent)
    triangles = sum(len(part) for part in materials.values())
    print(f"{name}: {triangles} triangles in {len(materials)} materials; left out: {', '.join(left_out) or 'nothing'}")
    sensor = root.find("sensor")
    fov = float(sensor.find("float[@name='fov']").get("value")) if sensor.find("float[@name='fov']") is not None else 50
    camera = transform(sensor.find("transform"))
    forward, eye = camera[:3, 2] / np.linalg.norm(camera[:3, 2]), camera[:3, 3]
    camera[:3, 1] /= np.linalg.norm(camera[:3, 1])
    # Mitsuba looks along +z with x to the left. A mirrored camera is turned into one that is not, on both sides.
    camera[:3, 2] = forward
    camera[:3, 0] = np.cross(camera[:3, 1], forward)
    sky = int(any(item.get("type") in SKIES for item in root.findall("emitter")))
    extent = np.linalg.norm(np.ptp(np.concatenate([part.reshape(-1, 3) for part in materials.values()]), axis=0))
    values = {"eye": eye, "rotation": angles(camera)}
    texts = {key: f"({value[0]:.7g}, {value[1]:.7g}, {value[2]:.7g})" for key, value in values.items()}
    write_glb(out / f"{name}.glb", materials)
    (out / f"{name}.scene.ron").write_text(SCENE.format(sky=sky, fov=fov, near=f"{extent * 1e-4:.3g}", name=name, **texts))
    arrays = {"camera": camera, "fov": fov, "sky": sky, "near": extent * 1e-4}
    for number, ((reflectance, radiance), part) in enumerate(materials.items()):
        arrays |= {f"triangles{number}": part, f"reflectance{number}": reflectance, f"radiance{number}": radiance}
    np.savez_compressed(out / f"{name}.npz", **arrays)


main()
