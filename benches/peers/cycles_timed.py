"""Renders a scene with Cycles and times it. Arguments: SCENE WIDTH HEIGHT SAMPLES SEED THREADS OUT.exr [box].
Prints "seconds WALL CPU" of the render alone, its tree included, loading and writing left out. Needs Python with bpy (pip install bpy).

Path tracing as `rayloom render --integrator path` does it: no denoiser, no adaptive sampling, the scene's own bounces and clamps.
"""

import os
import resource
import sys
import time

# Blender's own setting is no limit: with one thread asked for two were busy.
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: int(sys.argv[6])])

import bpy


def main(scene_path, width, height, samples, seed, threads, out, pixel_filter=""):
    if scene_path.endswith(".blend"):
        bpy.ops.wm.open_mainfile(filepath=scene_path)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        # Lamps as rayloom takes them: candela are watts per steradian.
        bpy.ops.import_scene.gltf(filepath=scene_path, export_import_convert_lighting_mode="COMPAT")
        # A factory's clamp and blur are no part of the file.
        bpy.context.scene.cycles.sample_clamp_indirect = bpy.context.scene.cycles.blur_glossy = 0
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = next((o for o in scene.objects if o.type == "CAMERA"), None)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.use_border = False
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed, cycles.use_animated_seed = samples, seed, False
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    if pixel_filter == "box":
        cycles.pixel_filter_type = "BOX"
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    for view_layer in scene.view_layers:
        view_layer.samples = 0
    scene.render.filepath = out
    used = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    # The second render has the kernels loaded and the scene in Blender's own form.
    bpy.context.scene.cycles.samples = 1
    bpy.ops.render.render()
    bpy.context.scene.cycles.samples = samples
    wall, cpu = time.perf_counter(), used()
    bpy.ops.render.render()
    wall, cpu = time.perf_counter() - wall, used() - cpu
    bpy.data.images["Render Result"].save_render(out)
    print(f"seconds {wall:.6f} {cpu:.6f}", flush=True)


main(os.path.abspath(sys.argv[1]), *map(int, sys.argv[2:7]), os.path.abspath(sys.argv[7]), *sys.argv[8:])
# Blender's own tidying up at the end may hang in this build of it.
os._exit(0)
