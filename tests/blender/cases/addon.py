# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension itself: installing, rendering by F12, devices, cancelling, crashes, the viewport, animation."""

import glob
import os
import signal
import sys
import threading
import time

import bpy
import numpy as np
import stage
from stage import ADDON, alive, emission, layers_of, lit_room, load, log_texts, module, new_scene, render, render_error, say, wall


def case_installs_and_renders():
    """Colours arrive linear, upright and unmirrored."""
    new_scene()
    for k, color in enumerate(((1, 0, 0), (0, 0.5, 0), (0, 0, 0.25), (0.5, 0.5, 0.5))):
        x, z = k % 2, k // 2
        wall(f"W{k}", x * 4 - 4, x * 4, z * 4 - 4, z * 4, material=emission(f"E{k}", color))
    p = render()
    assert p.shape == (48, 64, 4), p.shape
    assert np.allclose(p[40, 8, :3], (1, 0, 0), atol=1e-3), p[40, 8]
    assert np.allclose(p[40, 56, :3], (0, 0.5, 0), atol=1e-3), p[40, 56]
    assert np.allclose(p[8, 8, :3], (0, 0, 0.25), atol=1e-3), p[8, 8]
    assert np.allclose(p[8, 56], (0.5, 0.5, 0.5, 1), atol=1e-3), p[8, 56]


def case_crop_and_percentage():
    """Border with and without crop, and resolution percentage, show their part of the picture."""
    scene = new_scene((128, 96))
    wall("L", -9, 0, -9, 9, material=emission("L", (1, 0, 0)))
    wall("R", 0, 9, -9, 9, material=emission("R", (0, 1, 0)))
    scene.render.resolution_percentage = 50
    assert render().shape[:2] == (48, 64)
    scene.render.use_border = scene.render.use_crop_to_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.5, 1.0
    p = render()
    assert p.shape[:2] == (24, 32), p.shape
    assert np.allclose(p[:, :15, :3], (1, 0, 0), atol=1e-3) and np.allclose(p[:, 17:, :3], (0, 1, 0), atol=1e-3)
    scene.render.use_crop_to_border = False
    p = render()
    assert p.shape[:2] == (48, 64), p.shape
    assert np.allclose(p[:24, 16:31, :3], (1, 0, 0), atol=1e-3), p[12, 20]
    assert np.all(p[26:, :, :3] == 0) and np.all(p[:, :15, :3] == 0), "outside of the border is nothing"


def case_film_transparent():
    """The background has alpha 0, what stands before it 1."""
    scene = new_scene()
    scene.render.film_transparent = True
    wall("W", -0.5, 0.5, -0.5, 0.5, material=emission("E", (0.2, 0.4, 0.6)))
    p = render()
    assert np.allclose(p[24, 32], (0.2, 0.4, 0.6, 1), atol=1e-3), p[24, 32]
    assert np.all(p[2, 2] == 0), p[2, 2]


def case_view_layers():
    """Each layer shows its own collections, and is kept apart in a multilayer file."""
    scene = new_scene()
    wall("Left", -9, 0, -9, 9, material=emission("R", (1, 0, 0)))
    group = bpy.data.collections.new("Right")
    scene.collection.children.link(group)
    right = wall("RightWall", 0, 9, -9, 9, material=emission("G", (0, 1, 0)))
    scene.collection.objects.unlink(right)
    group.objects.link(right)
    second = scene.view_layers.new("Second")
    second.layer_collection.children["Right"].exclude = True
    render("layers", layers=True)
    planes, _ = layers_of(os.path.join(stage.FOLDER, "layers.exr"))
    first, other = (np.stack([planes[f"{name}.Combined.{c}"] for c in "RGB"], axis=-1) for name in ("ViewLayer", "Second"))
    assert np.allclose(first[24, 8], (1, 0, 0), atol=1e-3) and np.allclose(first[24, 56], (0, 1, 0), atol=1e-3), (first[24, 8], first[24, 56])
    assert np.allclose(other[24, 8], (1, 0, 0), atol=1e-3) and np.all(other[24, 56] == 0), (other[24, 8], other[24, 56])


def case_animation_keeps_buffers():
    """Three frames differ; the mesh that does not change is written once."""
    scene = new_scene()
    mover = wall("Mover", -0.5, 0.5, -0.5, 0.5, material=emission("E", (1, 1, 1)))
    for frame, x in ((1, -1.5), (3, 1.5)):
        mover.location.x = x
        mover.keyframe_insert("location", frame=frame)
    n = 150
    mesh = bpy.data.meshes.new("Grid")
    grid = np.stack([*np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n)), np.full((n, n), -3.0)], axis=-1).reshape(-1, 3)
    corner = np.arange(n * n).reshape(n, n)
    faces = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=-1).reshape(-1, 4)
    mesh.from_pydata(grid.tolist(), [], faces.tolist())
    scene.collection.objects.link(bpy.data.objects.new("Grid", mesh))
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.join(stage.FOLDER, "frame_")
    written = []
    gltf = module("core.glb").Gltf
    original = gltf.write
    gltf.write = lambda self, path: (original(self, path), written.append((self.written_bytes, self.kept_bytes)))[0]
    bpy.ops.render.render(animation=True)
    frames = [load(os.path.join(stage.FOLDER, f"frame_{k:04}.exr")) for k in (1, 2, 3)]
    centers = [np.average(np.arange(64), weights=f[:, :, 0].sum(axis=0)) for f in frames]
    assert centers[0] < 20 < 30 < centers[1] < 34 < 44 < centers[2], centers
    assert written[0][0] > 500_000 and written[1][0] < 100_000 and written[1][1] > 400_000, written


def case_a_time_limit_ends_the_rendering():
    """A picture is there when the time is over, all of it, and the log says how many samples it has."""
    scene = lit_room(samples=1_000_000, size=(128, 96))
    scene.rayloom.time_limit = 2.0
    start = time.monotonic()
    p = render()
    took = time.monotonic() - start
    told = [t for t in log_texts() if "samples a pixel" in t]
    say(f"{took:.1f} s with a limit of 2 s; {told}")
    assert took < 6.0 and len(told) == 1, (took, log_texts())
    assert (p[..., 3] == 1).all() and np.isfinite(p).all() and p[..., :3].mean() > 0.1, "every pixel has samples"


def case_the_viewport_keeps_up():
    """Blender's default scene as in a viewport, without a window: five pictures a second while the view turns, no call that takes long, the picture of F12."""
    bpy.ops.wm.read_factory_settings()
    bpy.ops.preferences.addon_enable(module=ADDON)
    scene = bpy.context.scene
    scene.render.engine, scene.rayloom.device, scene.rayloom.follow_cycles = "RAYLOOM", "CPU", False
    scene.render.resolution_x, scene.render.resolution_y = 480, 270
    scene.rayloom.samples, scene.rayloom.use_adaptive_sampling = 32, False
    size, viewport, camera = (480, 270), module("viewport"), scene.camera
    camera.data.shift_x = 0.1
    depsgraph = bpy.context.evaluated_depsgraph_get()
    view = viewport.View(os.path.join(stage.FOLDER, "view"))
    start = time.perf_counter()
    assert view.update(depsgraph)
    exported = time.perf_counter() - start
    projection = camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1])
    place = camera.matrix_world.copy()
    import mathutils

    longest, first_seen, frames, serials = 0.0, [], 0, set()
    begin = time.perf_counter()
    turn = 0
    while time.perf_counter() - begin < 6.0:
        # A new view every half second, as a hand turns it.
        if time.perf_counter() - begin >= 0.5 * turn:
            turn += 1
            place = mathutils.Matrix.Rotation(0.02, 4, "Z") @ place
            asked, waits = time.perf_counter(), True
        called = time.perf_counter()
        view.update(depsgraph)
        view.show(scene, projection, place, size)
        frame, _ = view.session.frame(), view.status()
        longest = max(longest, time.perf_counter() - called)
        if frame is not None and frame.serial not in serials:
            serials.add(frame.serial)
            frames += 1
        if waits and frame is not None and frame.wish.key == view.key:
            first_seen.append(time.perf_counter() - asked)
            waits = False
        time.sleep(1 / 60)
    say(f"export {exported * 1000:.0f} ms; {frames / 6.0:.1f} pictures a second; a new view is seen after {np.median(first_seen) * 1000:.0f} ms; longest call {longest * 1000:.1f} ms")
    assert frames / 6.0 >= 5.0, frames
    assert longest < 0.1, longest
    # The view of the camera is the picture of F12.
    view.show(scene, projection, camera.matrix_world, size)
    scene.rayloom.samples = 64
    end = time.monotonic() + 60
    while view.session.busy() and time.monotonic() < end:
        time.sleep(0.02)
    seen = view.session.frame().pixels[::-1, :, :3]
    assert view.session.error() is None and seen.shape[:2] == (270, 480), view.session.error()
    whole = render()[:, :, :3]
    off = float(np.abs(np.clip(seen, 0, 1).mean() - np.clip(whole, 0, 1).mean()))
    say(f"mean {seen.mean():.4f}, by F12 {whole.mean():.4f}, median difference {np.median(np.abs(seen - whole)):.4f}")
    assert off < 0.01 and np.median(np.abs(seen - whole)) < 0.02
    view.session.close()
    view.session.join(5.0)
    # Off, the engine has no viewport; on, it has; drawing calls what Blender offers.
    engine = module("engine").RayloomRenderEngine
    assert "view_draw" not in engine.__dict__
    bpy.context.preferences.addons[ADDON].preferences.viewport = True
    assert "view_draw" in engine.__dict__ and engine.is_registered
    bpy.context.preferences.addons[ADDON].preferences.viewport = False
    assert "view_draw" not in engine.__dict__ and engine.is_registered
    calls = []
    import types

    fakes = {
        "gpu": types.SimpleNamespace(
            types=types.SimpleNamespace(Buffer=lambda kind, n, data: calls.append((kind, n, data.size)) or data, GPUTexture=lambda size, format, data: (size, format)),
            state=types.SimpleNamespace(blend_set=calls.append),
        ),
        "gpu_extras.presets": types.SimpleNamespace(draw_texture_2d=lambda texture, at, w, h: calls.append((texture, at, w, h))),
    }
    kept = {name: sys.modules.get(name) for name in fakes}
    sys.modules.update(fakes)
    shader = types.SimpleNamespace(bind_display_space_shader=lambda s: calls.append("bind"), unbind_display_space_shader=lambda: calls.append("unbind"))
    viewport.draw(shader, scene, (960, 540), view.session.frame())
    sys.modules.update({k: v for k, v in kept.items() if v is not None})
    n = 480 * 270 * 4
    assert calls == [("FLOAT", n, n), "ALPHA_PREMULT", "bind", (((480, 270), "RGBA16F"), (0, 0), 960, 540), "unbind", "NONE"], calls


def case_the_picture_so_far_is_shown():
    """While it renders, Blender gets what there is; the memory and the time left are told; the end is whole."""
    scene = new_scene((256, 256), samples=60)
    scene.rayloom.use_adaptive_sampling = False
    material = bpy.data.materials.new("M")
    material.use_nodes = True
    wall("W", -9, 9, -9, 9, material=material)
    scene.world = bpy.data.worlds.new("World")
    engine = module("engine")
    engine.SHOW_IN_BACKGROUND = True
    shown, show, said = [], engine.LiveResult.show, []

    def noted(self):
        show(self)
        planes = np.fromfile(self.path, "<f4").reshape(256, 256, 4)
        shown.append((self.n_shown, float((planes[..., 3] > 0).mean())))

    engine.LiveResult.show = noted
    say_stage = engine.RayloomRenderEngine._say
    engine.RayloomRenderEngine._say = lambda self, stage, share: (said.append(stage), say_stage(self, stage, share))[1]
    p = render()
    engine.LiveResult.show, engine.RayloomRenderEngine._say = show, say_stage
    say(f"shown {len(shown)} times, shares {[round(s, 2) for _, s in shown]}; {next((s for s in said if 'MiB' in s), 'no memory told')}")
    assert len(shown) >= 2 and shown[-1][0] == len(shown) and 0.0 < shown[0][1] < 1.0, shown
    assert any("left" in s and "MiB" in s for s in said), said[-5:]
    assert p.shape == (256, 256, 4) and (p[..., 3] > 0.99).all() and p[..., :3].std() < 0.2


def case_devices_by_name():
    """The renderer is told the GPU's name; a GPU that is not there is an error in words."""
    scene = new_scene()
    command = module("engine").command_line
    scene.rayloom.device, scene.rayloom.gpu = "GPU", "No Such Card"
    line = command("rayloom", scene, "a", "b", "c")
    assert line[line.index("--device") + 1] == "No Such Card" and "--backend" not in line
    scene.rayloom.integrator = "CLASSIC"
    wall("W", -9, 9, -9, 9, material=emission("E", (1, 1, 1)))
    render_error("No Such Card")
    scene.rayloom.device = "CPU"
    line = command("rayloom", scene, "a", "b", "c")
    assert line[line.index("--backend") + 1] == "cpu" and "--device" not in line


def case_cancel_is_fast():
    """A break ends the renderer within half a second, and Blender goes on."""
    scene = new_scene((1024, 1024), samples=100_000)
    wall("W", -9, 9, -9, 9, material=emission("E", (1, 1, 1)))
    process = module("core.process")
    seen, drive = {}, process.drive

    def drive_with_break(renderer, on_event, is_cancelled, pause=0.05):
        seen["pid"], start = renderer.pid, time.monotonic()

        def breaks():
            if is_cancelled() or time.monotonic() - start > 1.0:
                seen.setdefault("break", time.monotonic())
            return "break" in seen

        return drive(renderer, on_event, breaks, pause)

    process.drive = drive_with_break
    bpy.ops.render.render(write_still=False)
    process.drive = drive
    took = time.monotonic() - seen["break"]
    say(f"cancelled in {took:.3f} s")
    assert took < 0.5, took
    assert not alive(seen["pid"]), "the renderer still runs"
    scene.rayloom.samples = 1
    scene.render.resolution_x = scene.render.resolution_y = 32
    assert render()[16, 16, 0] > 0.99, "the next render works"


def case_interrupt_ends_the_renderer():
    """Control-C in a script: the renderer goes, the operator fails, the next render works."""
    scene = new_scene((1024, 1024), samples=100_000)
    wall("W", -9, 9, -9, 9, material=emission("E", (1, 1, 1)))
    process = module("core.process")
    seen, started = {}, process.Renderer.__init__

    def noted(self, *args):
        started(self, *args)
        seen["pid"] = self.pid
        threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT)).start()

    process.Renderer.__init__ = noted
    render_error("Interrupted")
    process.Renderer.__init__ = started
    assert not alive(seen["pid"]), "the renderer still runs"
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.rayloom.samples = 1
    assert render()[16, 16, 0] > 0.99


def case_killed_renderer_is_an_error():
    """A renderer that dies is an error with its signal; the next render works."""
    scene = new_scene((1024, 1024), samples=100_000)
    wall("W", -9, 9, -9, 9, material=emission("E", (1, 1, 1)))
    process = module("core.process")
    started = process.Renderer.__init__

    def noted(self, *args):
        started(self, *args)
        threading.Timer(0.7, os.kill, (self.pid, signal.SIGKILL)).start()

    process.Renderer.__init__ = noted
    render_error("signal 9")
    process.Renderer.__init__ = started
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.rayloom.samples = 1
    assert render()[16, 16, 0] > 0.99


def case_missing_program_and_camera_are_errors():
    """What is missing is said in the interface."""
    scene = new_scene()
    preferences = bpy.context.preferences.addons[ADDON].preferences
    preferences.program_path = "/nowhere/rayloom"
    render_error("/nowhere/rayloom")
    preferences.program_path = sys.executable
    render_error("is not rayloom")
    preferences.program_path = ""
    camera, scene.camera = scene.camera, None
    render_error("camera")
    scene.camera = camera
    render()


def case_panels_join_and_leave():
    """Blender's and Cycles' panels take the engine while the add-on is on, and are as before afterwards."""
    before = {p.__name__: set(p.COMPAT_ENGINES) for p in bpy.types.Panel.__subclasses__() if hasattr(p, "COMPAT_ENGINES")}
    joined = [n for n, engines in before.items() if "RAYLOOM" in engines]
    say(f"{len(joined)} panels")
    assert "DATA_PT_lens" in joined and "CYCLES_LIGHT_PT_light" in joined and "CYCLES_RENDER_PT_sampling" not in joined
    bpy.ops.preferences.addon_disable(module=ADDON)
    panels = [p for p in bpy.types.Panel.__subclasses__() if hasattr(p, "COMPAT_ENGINES") and not p.__name__.startswith("RAYLOOM_")]
    after = {p.__name__: set(p.COMPAT_ENGINES) for p in panels}
    assert not [n for n, engines in after.items() if "RAYLOOM" in engines]
    assert all(after[n] == before[n] - {"RAYLOOM"} for n in after if n in before)


def case_given_scenes_render():
    """The .blend files of --scenes render by F12's operator to their size, finite and not black; with --references as a table against Cycles' pictures."""
    references, samples = os.environ.get("RAYLOOM_REFERENCES"), int(os.environ.get("RAYLOOM_SAMPLES") or 1)
    if references:
        say("scene\tsamples\trmse_clamped_to_1\tcycles_at_256\tmean_clamped_over_cycles")
    for path in sorted(glob.glob(os.path.join(os.environ.get("RAYLOOM_SCENES") or "/nowhere", "*.blend"))):
        bpy.ops.wm.open_mainfile(filepath=path)
        scene = bpy.context.scene
        scene.render.engine = "RAYLOOM"
        scene.rayloom.device = "CPU"
        scene.cycles.samples = samples
        name = os.path.splitext(os.path.basename(path))[0]
        p = render(name)
        assert p.shape[:2] == (scene.render.resolution_y, scene.render.resolution_x), (name, p.shape)
        assert np.isfinite(p).all() and p[:, :, :3].mean() > 1e-3, name
        if references:
            ours, theirs, noisy = (
                np.clip(a[:, :, :3], 0.0, 1.0) for a in (p, *(load(os.path.join(references, f"{name}{tag}.exr")) for tag in ("", "_mid")))
            )
            rmse, own = (float(np.sqrt(((a - theirs) ** 2).mean())) for a in (ours, noisy))
            say(f"{name}\t{samples}\t{rmse:.4f}\t{own:.4f}\t{ours.mean() / theirs.mean():.4f}")
        else:
            say(f"{name}: mean {p[:, :, :3].mean():.4f}; {len([t for t in log_texts() if not t.startswith(': ')])} things left out or approximated")
