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

from . import viewport
from .bridge.scene import Exporter
from .bridge.settings import border_of, denoiser_record, denoises, picture_size, settings_of, wanted_passes
from .core import denoiser, exr, log, passes, process, program
from .exporting import generator
from .preferences import preferences

_folder = None
# Nobody looks in the background; the tests do.
SHOW_IN_BACKGROUND = False


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


def denoise_options(scene, view_layer):
    """The renderer's options for denoising: always said, so that a missing library is an error and no noisy picture passes for a clean one."""
    if not denoises(scene, view_layer) or scene.rayloom.integrator != "PATH":
        return ["--no-denoise"]
    wanted = denoiser_record(settings_of(scene))
    guides = "albedo-normal" if wanted["guides"] == "albedoNormal" else wanted["guides"]
    out = ["--denoise", "--denoise-guides", guides, "--denoise-prefilter", wanted["prefilter"], "--denoise-quality", wanted["quality"]]
    library = denoiser.find(os.path.dirname(bpy.utils.resource_path("LOCAL")), bpy.app.binary_path)
    return out + (["--denoise-library", library] if library else [])


def command_line(path, scene, source, target, live, view_layer=None):
    """The renderer's command for a scene's settings; `live` gets the picture so far."""
    render, settings, own = scene.render, settings_of(scene), scene.rayloom
    width, height = picture_size(render)
    samples = settings.samples
    out = [path, "render", source, "-o", target, "--size", f"{width}x{height}", "--spp", str(max(1, samples))]
    out += ["--progress", "json", "--stop-with-stdin", "--live", live]
    out += denoise_options(scene, view_layer)
    out += ["--integrator", own.integrator.lower(), "--accel", own.accelerator.lower()]
    out += ["--device", own.gpu] if own.device == "GPU" and own.gpu else ["--backend", own.device.lower()]
    border = border_of(render)
    if border:
        out += ["--crop", ",".join(map(str, border))]
    if settings.time_limit > 0.0 and own.integrator == "PATH":
        out += ["--time-limit", f"{settings.time_limit:.3f}"]
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
        self._view = None

    def __del__(self):
        child, view = getattr(self, "child", None), getattr(self, "_view", None)
        if child is not None:
            child.stop()
        if view is not None:
            view.session.close()

    def view(self):
        """What this engine shows in a viewport."""
        if self._view is None:
            self._view = viewport.View(tempfile.mkdtemp(prefix="view-", dir=session_folder()))
        return self._view

    def update_render_passes(self, scene=None, renderlayer=None):
        """Tells Blender which passes come."""
        ranks = getattr(renderlayer, "pass_cryptomatte_depth", 6)
        keeps_noise = getattr(getattr(renderlayer, "cycles", None), "denoising_store_passes", False) and denoises(scene, renderlayer)
        more = passes.DENOISING_DATA if keeps_noise else ()
        for name, channels, kind in passes.registered(wanted_passes(renderlayer, scene), ranks, more, bpy.app.version):
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
        source, target, live = (os.path.join(folder, name) for name in ("scene.gltf", "picture.exr", "live"))
        self._say("Exporting", 0.0)
        start = time.perf_counter()
        exporter = Exporter(depsgraph, generator(), keep=os.path.join(folder, "buffers"))
        exporter.export(source, lambda frame, sub: self.frame_set(frame, subframe=sub))
        for owner, what in exporter.log.entries:
            log.add("warning", owner, what)
        exported = time.perf_counter() - start
        log.add("note", "", f"exported in {exported:.2f} s, {exporter.gltf.written_bytes:,} bytes written, {exporter.gltf.kept_bytes:,} kept")
        forget_old_buffers(os.path.join(folder, "buffers"), exporter.gltf.kept_files)
        for old in filter(os.path.exists, (target, live)):
            os.unlink(old)
        told = {e for pair in exporter.log.entries for e in [f"{pair[0]}: {pair[1]}"]}
        self.child = process.Renderer(command_line(path, scene, source, target, live, depsgraph.view_layer), folder)
        so_far = None if bpy.app.background and not SHOW_IN_BACKGROUND else LiveResult(self, live, scene, depsgraph)
        try:
            finished = process.drive(self.child, lambda event: self._event(event, told, so_far), self.test_break)
        except BaseException:
            if so_far:
                so_far.end()
            raise
        finally:
            self.child = None
        if not finished:
            if so_far:
                so_far.end()
            return
        self._show(exr.read(target), scene, depsgraph, so_far)

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

    def _event(self, event, told, so_far):
        kind = event.get("event")
        if kind == "progress" and event.get("total"):
            share = event["done"] / event["total"]
            left = event.get("seconds_left") or 0.0
            used, peak = ((event.get(key) or 0) / 2**20 for key in ("memory", "memory_peak"))
            self._say(f"{100.0 * share:.0f} %, {_clock(left)} left, {used:.0f} MiB", share)
            self.update_memory_stats(memory_used=used, memory_peak=peak)
        elif kind == "finished":
            samples = (event.get("stats") or {}).get("samples") or {}
            if samples.get("time_limit_reached"):
                log.add("note", "", f"the time limit left {samples['mean']:.1f} samples a pixel ({samples['least']} to {samples['most']})")
        elif kind == "picture" and so_far:
            so_far.show()
        elif kind == "rendering":
            self._say(f"Rendering on {event.get('device', '')}", 0.0)
            log.add("note", "", f"rendered on {event.get('device', '')}")
        elif kind == "denoising":
            self._say("Denoising", event.get("share") or 0.0)
        elif kind in {"loading", "compiling", "writing"}:
            self._say(kind.capitalize(), 0.0 if kind != "writing" else 1.0)
        elif kind == "diagnostic" and event.get("message") not in told:
            level = {"error": "error", "warning": "warning"}.get(event.get("severity"), "note")
            log.add(level, "", event.get("message", ""))

    def _show(self, picture, scene, depsgraph, so_far=None):
        """Puts the planes of the renderer's file into Blender's passes, bottom row first."""
        width, height = self._size(scene)
        border = border_of(scene.render)
        if (picture.width, picture.height) != picture_size(scene.render):
            raise process.RendererError(f"The renderer made {picture.width} x {picture.height} pixels, not the size that was asked for")
        rows = slice(border[1], border[3]) if border else slice(None)
        columns = slice(border[0], border[2]) if border else slice(None)
        result = (so_far and so_far.result) or self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)
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


class LiveResult:
    """The picture so far in Blender's Combined pass, taken from the renderer's file (`--live`)."""

    def __init__(self, engine, path, scene, depsgraph):
        self.engine, self.path, self.size = engine, path, picture_size(scene.render)
        self.border = border_of(scene.render) or [0, 0, *self.size]
        self.layer = depsgraph.view_layer.name
        self.result = None
        self.n_shown = 0

    def show(self):
        """Shows what the file holds now; a file that is not there or of a wrong length shows nothing."""
        width, height = self.size
        try:
            flat = np.fromfile(self.path, "<f4")
        except OSError:
            return
        if flat.size != 4 * width * height:
            return
        left, top, right, bottom = self.border
        pixels = flat.reshape(height, width, 4)[top:bottom, left:right][::-1]
        if self.result is None:
            self.result = self.engine.begin_result(0, 0, right - left, bottom - top, layer=self.layer)
        combined = next((p for p in self.result.layers[0].passes if p.name == "Combined"), None)
        if combined is not None:
            combined.rect.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
            self.engine.update_result(self.result)
            self.n_shown += 1

    def end(self):
        """Gives the result back without a picture."""
        if self.result is not None:
            self.engine.end_result(self.result, cancel=True)
            self.result = None


def forget_old_buffers(folder, used):
    """Buffers that the last frame did not use go, so that an animation does not fill the disk."""
    for name in os.listdir(folder) if os.path.isdir(folder) else ():
        if name.endswith(".bin") and name not in used:
            os.unlink(os.path.join(folder, name))


def _clock(seconds):
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes:02}:{seconds:02}"
