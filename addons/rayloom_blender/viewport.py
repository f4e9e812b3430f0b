# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine in the viewport's Rendered mode. All that draws is in `draw`; the rest runs without a window (core/viewport.py)."""

import json
import os
import time

import bpy

from .bridge.scene import Exporter
from .bridge.settings import settings_of
from .core import log, program
from .core.viewport import INTERVAL, Session, Wish, camera_of, with_camera
from .exporting import generator
from .preferences import preferences

# Exporting takes at most one part of so many of the time.
EXPORT_SHARE = 5


class View:
    """One viewport: the scene as it was exported last, and the session that renders it."""

    def __init__(self, folder):
        self.folder = folder
        self.session = Session(folder)
        self.document, self.serial, self.due, self.stale = None, 0, 0.0, True
        self.key, self.settings = None, None

    def update(self, depsgraph, now=None):
        """Exports the scene if it changed and the last export is long enough ago; true when it did."""
        now = time.perf_counter() if now is None else now
        if not self.stale or now < self.due:
            return False
        exporter = Exporter(depsgraph, generator(), keep=os.path.join(self.folder, "buffers"))
        exporter.export(os.path.join(self.folder, "scene.gltf"))
        for owner, what in exporter.log.entries:
            log.add("warning", owner, what)
        took = time.perf_counter() - now
        self.document, self.serial, self.stale = exporter.gltf.document, self.serial + 1, False
        self.due = now + EXPORT_SHARE * max(took, 0.0)
        return True

    def show(self, scene, projection, to_world, size):
        """Asks for a picture of the view, if it is another than that which was asked for."""
        if self.document is None:
            return
        key = (self.serial, size, tuple(map(tuple, projection)), tuple(map(tuple, to_world)))
        if key == self.key:
            return
        self.key = key
        document, (camera, matrix) = self.document, camera_of(projection, to_world, size)
        path = program.checked(preferences().program_path)
        samples = max(1, getattr(settings_of(scene), "preview_samples", 0) or 64)
        transparent = scene.render.film_transparent

        def write(target):
            with open(target, "w", encoding="utf-8") as file:
                json.dump(with_camera(document, camera, matrix), file)

        def command(source, live, part, n):
            out = [path, "render", source, "--no-output", "--live", live, "--live-interval", str(INTERVAL), "--in-rounds", "--progress", "json"]
            out += ["--stop-with-stdin", "--size", f"{part[0]}x{part[1]}", "--spp", str(n), "--integrator", "path", "--backend", "cpu"]
            out += ["--no-denoise", "--passes", "none", "--noise-threshold", "0", "--time-limit", "0"]
            return out + (["--alpha"] if transparent else [])

        self.session.show(Wish(size, samples, write, command, key))

    def status(self):
        """A line for the viewport."""
        return self.session.error() or ("Rendering" if self.session.busy() else "Done")


def draw(engine, scene, size, frame):
    """Draws a picture over the whole region."""
    import gpu
    from gpu_extras.presets import draw_texture_2d

    height, width = frame.pixels.shape[:2]
    buffer = gpu.types.Buffer("FLOAT", width * height * 4, frame.pixels.ravel())
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
    gpu.state.blend_set("ALPHA_PREMULT")
    engine.bind_display_space_shader(scene)
    draw_texture_2d(texture, (0, 0), *size)
    engine.unbind_display_space_shader()
    gpu.state.blend_set("NONE")


def view_update(self, context, depsgraph):
    """Blender: the scene changed."""
    self.view().stale = True
    self.tag_redraw()


def view_draw(self, context, depsgraph):
    """Blender: draw now. Whatever goes wrong is a line in the viewport."""
    view, region, seen = self.view(), context.region, context.region_data
    size = (region.width, region.height)
    try:
        view.update(depsgraph)
        view.show(depsgraph.scene, seen.window_matrix, seen.view_matrix.inverted(), size)
        frame = view.session.frame()
        if frame is not None:
            draw(self, depsgraph.scene, size, frame)
        self.update_stats("Rayloom", view.status())
    except (program.ProgramError, ValueError, OSError, RuntimeError) as e:
        self.update_stats("Rayloom", str(e))
        return
    if view.session.busy() or view.stale:
        self.tag_redraw()


def switch(engine, on):
    """Gives the engine its viewport or takes it away; it must be registered anew for Blender to see that."""
    for name, function in (("view_update", view_update), ("view_draw", view_draw)):
        if on:
            setattr(engine, name, function)
        elif name in engine.__dict__:
            delattr(engine, name)


def again(engine, on):
    """Switches while the add-on is on."""
    bpy.utils.unregister_class(engine)
    switch(engine, on)
    bpy.utils.register_class(engine)
