"""Path traces a converted scene with Mitsuba 3: python mitsuba3.py NAME.npz OUT.exr SIZE SAMPLES [BOUNCES]

The image is square, in linear radiance. SAMPLES are rendered in two halves, whose difference gives the noise that is printed.
BOUNCES counts indirect bounces; without it paths end by Russian roulette alone. Needs `mitsuba`, numpy and OpenEXR (PyPI).
"""

import sys
import tempfile
from pathlib import Path

import mitsuba
import numpy as np
import OpenEXR

mitsuba.set_variant("scalar_rgb")
BLACK = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0, 0, 0]}}


def scene(arrays, size, depth, folder):
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    camera = {"type": "perspective", "fov": float(arrays["fov"]), "near_clip": float(arrays["near"]), "far_clip": 1e6}
    camera |= {"to_world": mitsuba.ScalarTransform4f(arrays["camera"].tolist()), "film": film}
    found = {"type": "scene", "sensor": camera}
    found["integrator"] = {"type": "path", "max_depth": depth, "rr_depth": 12}
    if arrays["sky"] > 0:
        found["sky"] = {"type": "constant", "radiance": float(arrays["sky"])}
    for number in range(sum(name.startswith("triangles") for name in arrays)):
        file = folder / f"{number}.ply"
        write_ply(file, arrays[f"triangles{number}"])
        shape = {"type": "ply", "filename": str(file), "face_normals": True}
        radiance, reflectance = (arrays[f"{name}{number}"].tolist() for name in ("radiance", "reflectance"))
        if max(radiance) > 0:
            shape |= {"emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}, "bsdf": BLACK}
        else:
            diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}}
            shape["bsdf"] = {"type": "twosided", "sides": diffuse}
        found[f"shape{number}"] = shape
    return mitsuba.load_dict(found)


def write_ply(path, triangles):
    points = triangles.reshape(-1, 3).astype("<f4")
    faces = np.zeros(len(triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, np.arange(len(points)).reshape(-1, 3)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(head.encode() + points.tobytes() + faces.tobytes())


def main():
    arrays = dict(np.load(sys.argv[1]))
    size, samples = int(sys.argv[3]), int(sys.argv[4])
    depth = int(sys.argv[5]) + 2 if len(sys.argv) > 5 else -1
    with tempfile.TemporaryDirectory() as folder:
        loaded = scene(arrays, size, depth, Path(folder))
        halves = [np.array(mitsuba.render(loaded, spp=samples // 2, seed=seed)) for seed in (1, 2)]
    image = (halves[0] + halves[1]) / 2
    noise = np.sqrt((((halves[0] - halves[1]) / 2).mean(-1) ** 2).mean()) / image.mean()
    print(f"{sys.argv[1]}: {samples} samples, mean {image.mean():.6g}, noise {noise:.4f}")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(image, np.float32)}).write(sys.argv[2])


main()
