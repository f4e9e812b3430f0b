"""Renders a scene with Cycles, once with each seed. Arguments: SCENE WIDTH HEIGHT SAMPLES OUT0.exr OUT1.exr ... (the k-th with seed k).
Needs Python with bpy (pip install bpy).

Plain path tracing, so that the light is Cycles' own and nothing else: no denoiser, no adaptive sampling, no clamps, no filter on glossy
reflections; linear light in 32-bit floats.
"""

import os
import sys

import bpy  # noqa: this file must not be called cycles.py, as the add-on is


def main(scene_path, width, height, samples, outs):
    if scene_path.endswith(".blend"):
        bpy.ops.wm.open_mainfile(filepath=scene_path)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        if scene_path.endswith(".obj"):
            bpy.ops.wm.obj_import(filepath=scene_path)
        else:
            # Lamps as rayloom takes them: candela are watts per steradian.
            bpy.ops.import_scene.gltf(filepath=scene_path, export_import_convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = next((o for o in scene.objects if o.type == "CAMERA"), None)
    if scene.camera is None:
        raise SystemExit(f"{scene_path} has no camera")
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.use_border = False
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    if not scene_path.endswith(".blend"):
        # A Blender file's own settings stay; others have none, and rayloom takes none for them.
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.use_animated_seed = False
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    for view_layer in scene.view_layers:
        view_layer.samples = 0
    for seed, out in enumerate(outs):
        cycles.seed = seed
        scene.render.filepath = out
        bpy.ops.render.render(write_still=True)


main(os.path.abspath(sys.argv[1]), *map(int, sys.argv[2:5]), sys.argv[5:])
sys.stdout.flush()
# Blender's own tidying up at the end may hang in this build of it.
os._exit(0)
