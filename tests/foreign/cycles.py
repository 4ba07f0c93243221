"""Renders a glTF scene with Cycles and its denoiser, and prints the time of each image.

    python cycles.py SCENE.glb OUT_PREFIX SIZE SAMPLES[,SAMPLES…]

Needs `bpy` (PyPI). Lights have no size, the pixel filter is a box, and no light is clamped, as Lightwell and the independent
renderer of the references have it. OUT_PREFIX_SAMPLES.exr holds linear radiance up to a factor: compare.py fits the gain.
"""

import sys
import time

import bpy

CYCLES = {
    "device": "CPU",
    "use_adaptive_sampling": False,
    "max_bounces": 32,
    "diffuse_bounces": 32,
    "glossy_bounces": 32,
    "sample_clamp_direct": 0,
    "sample_clamp_indirect": 0,
    "blur_glossy": 0,
    "pixel_filter_type": "BOX",
    "filter_width": 1.0,
    "use_denoising": True,
    "denoiser": "OPENIMAGEDENOISE",
    "denoising_input_passes": "RGB_ALBEDO_NORMAL",
    "denoising_prefilter": "ACCURATE",
}


def load(path, size):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path, export_import_convert_lighting_mode="SPEC")
    scene = bpy.context.scene
    scene.camera = next(item for item in scene.objects if item.type == "CAMERA")
    for light in (item.data for item in scene.objects if item.type == "LIGHT"):
        setattr(light, "angle" if light.type == "SUN" else "shadow_soft_size", 0)
    scene.render.engine = "CYCLES"
    for name, value in CYCLES.items():
        setattr(scene.cycles, name, value)
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    return scene


def main():
    path, prefix, size, samples = sys.argv[1:5]
    scene = load(path, int(size))
    for count in samples.split(","):
        scene.cycles.samples = int(count)
        scene.render.filepath = f"{prefix}_{count}.exr"
        wall, processor = time.time(), time.process_time()
        bpy.ops.render.render(write_still=True)
        wall, processor = time.time() - wall, time.process_time() - processor
        print(f"{count} samples: {wall:.2f} s, {processor:.2f} s of processor time", flush=True)


main()
