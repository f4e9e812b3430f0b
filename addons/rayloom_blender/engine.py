# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: exports the depsgraph, starts the renderer, shows what it made. Whatever goes wrong reaches the user as text."""

import atexit
import os
import shutil
import tempfile
import time
import traceback

import bpy
import numpy as np

from .bridge.scene import Exporter
from .bridge.settings import border_of, picture_size, settings_of, wanted_passes
from .core import exr, log, passes, process, program
from .exporting import generator
from .preferences import preferences

_folder = None


def session_folder():
    """A folder of this Blender session: buffers of meshes stay in it from frame to frame."""
    global _folder
    if _folder is None or not os.path.isdir(_folder):
        _folder = tempfile.mkdtemp(prefix="rayloom-")
        atexit.register(forget_folder)
    return _folder


def forget_folder():
    """Removes the session's folder."""
    global _folder
    if _folder is not None:
        shutil.rmtree(_folder, ignore_errors=True)
        _folder = None


def command_line(path, scene, source, target):
    """The renderer's command for a scene's settings."""
    render, settings, own = scene.render, settings_of(scene), scene.rayloom
    width, height = picture_size(render)
    samples = settings.samples
    out = [path, "render", source, "-o", target, "--size", f"{width}x{height}", "--spp", str(max(1, samples))]
    out += ["--progress", "json", "--stop-with-stdin"]
    out += ["--integrator", own.integrator.lower(), "--backend", own.device.lower(), "--accel", own.accelerator.lower()]
    border = border_of(render)
    if border:
        out += ["--crop", ",".join(map(str, border))]
    if render.film_transparent:
        out.append("--alpha")
    seed = settings.seed + (scene.frame_current if getattr(settings, "use_animated_seed", False) else 0)
    out += ["--seed", str(seed & 0xFFFFFFFF)]
    if render.threads_mode == "FIXED":
        out += ["--threads", str(render.threads)]
    return out


class RayloomRenderEngine(bpy.types.RenderEngine):
    """Rayloom."""

    bl_idname = "RAYLOOM"
    bl_label = "Rayloom"
    # Icons of materials and the viewport's material preview are EEVEE's: nothing of ours can fail there.
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_postprocess = True

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.child = None
        self.shown = False

    def __del__(self):
        child = getattr(self, "child", None)
        if child is not None:
            child.stop()

    def update_render_passes(self, scene=None, renderlayer=None):
        """Tells Blender which passes come."""
        ranks = getattr(renderlayer, "pass_cryptomatte_depth", 6)
        for name, channels, kind in passes.registered(wanted_passes(renderlayer), ranks):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        """One picture. An exception that left here would make Blender say that all is well."""
        self.shown = False
        try:
            self._render(depsgraph)
        except (process.RendererError, program.ProgramError, exr.Unreadable) as e:
            self._fail(str(e))
        except KeyboardInterrupt:
            self._fail("Interrupted")
        except Exception as e:
            traceback.print_exc()
            self._fail(f"Rayloom failed: {type(e).__name__}: {e}")
        if not self.shown:
            self._show_nothing(depsgraph)

    def _fail(self, text):
        log.add("error", "", text)
        self.error_set(text)
        # Without a report the operator says FINISHED and saves a blank picture (measured, 4.5).
        self.report({"ERROR"}, text)

    def _render(self, depsgraph):
        scene = depsgraph.scene
        log.clear()
        if scene.camera is None:
            raise process.RendererError("The scene has no camera")
        path = program.checked(preferences().program_path)
        folder = session_folder()
        source, target = os.path.join(folder, "scene.gltf"), os.path.join(folder, "picture.exr")
        self._say("Exporting", 0.0)
        start = time.perf_counter()
        exporter = Exporter(depsgraph, generator(), keep=os.path.join(folder, "buffers"))
        exporter.export(source, lambda frame, sub: self.frame_set(frame, subframe=sub))
        for owner, what in exporter.log.entries:
            log.add("warning", owner, what)
        exported = time.perf_counter() - start
        log.add("note", "", f"exported in {exported:.2f} s, {exporter.gltf.written_bytes:,} bytes written, {exporter.gltf.kept_bytes:,} kept")
        forget_old_buffers(os.path.join(folder, "buffers"), exporter.gltf.kept_files)
        if os.path.exists(target):
            os.unlink(target)
        told = {e for pair in exporter.log.entries for e in [f"{pair[0]}: {pair[1]}"]}
        self.child = process.Renderer(command_line(path, scene, source, target), folder)
        try:
            finished = process.drive(self.child, lambda event: self._event(event, told), self.test_break)
        finally:
            self.child = None
        if not finished:
            return
        self._show(exr.read(target), scene, depsgraph)

    def _size(self, scene):
        border = border_of(scene.render)
        if border:
            return border[2] - border[0], border[3] - border[1]
        return picture_size(scene.render)

    def _show_nothing(self, depsgraph):
        """Ends without a picture. In the background Blender saves one even so, and crashes when there is none (measured, 4.5)."""
        result = self.begin_result(0, 0, *self._size(depsgraph.scene), layer=depsgraph.view_layer.name)
        self.end_result(result, cancel=not bpy.app.background)

    def _say(self, stage, share):
        self.update_stats("Rayloom", stage)
        self.update_progress(share)

    def _event(self, event, told):
        kind = event.get("event")
        if kind == "progress" and event.get("total"):
            share = event["done"] / event["total"]
            left = event.get("seconds_left", 0.0)
            self._say(f"{100.0 * share:.0f} %, {_clock(left)} left", share)
        elif kind == "rendering":
            self._say(f"Rendering on {event.get('device', '')}", 0.0)
            log.add("note", "", f"rendered on {event.get('device', '')}")
        elif kind in {"loading", "compiling", "writing"}:
            self._say(kind.capitalize(), 0.0 if kind != "writing" else 1.0)
        elif kind == "diagnostic" and event.get("message") not in told:
            level = {"error": "error", "warning": "warning"}.get(event.get("severity"), "note")
            log.add(level, "", event.get("message", ""))
        elif kind == "memory":
            self.update_memory_stats(memory_used=event.get("used", 0) / 2**20, memory_peak=event.get("peak", 0) / 2**20)

    def _show(self, picture, scene, depsgraph):
        """Puts the planes of the renderer's file into Blender's passes, bottom row first."""
        width, height = self._size(scene)
        border = border_of(scene.render)
        if (picture.width, picture.height) != picture_size(scene.render):
            raise process.RendererError(f"The renderer made {picture.width} x {picture.height} pixels, not the size that was asked for")
        rows = slice(border[1], border[3]) if border else slice(None)
        columns = slice(border[0], border[2]) if border else slice(None)
        result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)
        self.shown = True
        try:
            for render_pass in result.layers[0].passes:
                planes = passes.find(picture, render_pass.name, render_pass.channel_id)
                if planes is None:
                    log.add("warning", "", f"the pass '{render_pass.name}' is not rendered")
                    continue
                stacked = np.stack([p[rows, columns][::-1] for p in planes], axis=-1)
                render_pass.rect.foreach_set(np.ascontiguousarray(stacked, np.float32).ravel())
        finally:
            self.end_result(result)
        # Only the engine's own result takes them to the file's header (measured, 4.5).
        for key, value in passes.cryptomatte_fields(picture.attributes, depsgraph.view_layer.name).items():
            self.get_result().stamp_data_add_field(key, value)


def forget_old_buffers(folder, used):
    """Buffers that the last frame did not use go, so that an animation does not fill the disk."""
    for name in os.listdir(folder) if os.path.isdir(folder) else ():
        if name.endswith(".bin") and name not in used:
            os.unlink(os.path.join(folder, name))


def _clock(seconds):
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes:02}:{seconds:02}"
