# SPDX-License-Identifier: GPL-3.0-or-later
"""Interactive rendering without Blender: a thread that keeps a renderer busy with what is to be shown, and has the newest picture ready.

Nothing that the main thread calls here waits: `show` says what is wanted, `frame` gives what there is. A change ends the running renderer and starts
another, at a quarter of the size first.
"""

import os
import threading

import numpy as np

from . import process

# Parts of the full size that are rendered one after the other, and the samples of each; none: all that are wanted.
LADDER = ((4, 2), (1, None))
# Milliseconds between two pictures of a renderer.
INTERVAL = 80


class Wish:
    """What is to be shown: `write(path)` writes the scene's file, `command(path, live, size, samples)` is the renderer's. `key`: for whoever asks."""

    def __init__(self, size, samples, write, command, key=None):
        self.size, self.samples, self.write, self.command, self.key = size, samples, write, command, key


class Frame:
    """A picture: (height, width, 4) floats, bottom row first. `serial` counts pictures, `wish` is what it shows."""

    def __init__(self, pixels, serial, wish):
        self.pixels, self.serial, self.wish = pixels, serial, wish


class Session:
    """A thread and the renderer that it drives. `folder` is the session's own."""

    def __init__(self, folder, start=process.Renderer):
        self._folder, self._start = folder, start
        self._change = threading.Condition()
        self._wish, self._closed, self._busy = None, False, False
        self._frame, self._error = None, None
        self._child = None
        os.makedirs(folder, exist_ok=True)
        self._thread = threading.Thread(target=self._work, name="rayloom viewport", daemon=True)
        self._thread.start()

    def show(self, wish):
        """From now on shows this."""
        with self._change:
            self._wish, self._busy, self._error = wish, True, None
            self._change.notify_all()

    def frame(self):
        """The newest picture; `None` while there is none."""
        return self._frame

    def busy(self):
        """Whether more pictures will come."""
        return self._busy

    def error(self):
        """What went wrong with the last wish, in words."""
        return self._error

    def close(self):
        """Ends the renderer and the thread, soon."""
        with self._change:
            self._closed, self._busy = True, False
            self._change.notify_all()

    def join(self, seconds):
        """Waits for the thread's end (tests)."""
        self._thread.join(seconds)

    def _work(self):
        while True:
            with self._change:
                while self._wish is None and not self._closed:
                    self._change.wait()
                if self._closed:
                    return
                wish, self._wish = self._wish, None
            try:
                self._render(wish)
            except (process.RendererError, OSError, ValueError, TypeError) as e:
                self._error = str(e)
            with self._change:
                self._busy = self._wish is not None and not self._closed

    def _changed(self):
        return self._closed or self._wish is not None

    def _render(self, wish):
        path, live = os.path.join(self._folder, "view.gltf"), os.path.join(self._folder, "live")
        wish.write(path)
        for part, samples in LADDER:
            size = tuple(max(1, -(-n // part)) for n in wish.size)
            if os.path.exists(live):
                os.unlink(live)
            if self._changed():
                return
            child = self._start(wish.command(path, live, size, samples or wish.samples), self._folder)
            try:
                while child.running():
                    for event in child.events():
                        if event.get("event") == "picture":
                            self._take(live, size, wish)
                    with self._change:
                        if not self._changed():
                            self._change.wait(0.01)
                    if self._changed():
                        return
                child.wait_readers()
            finally:
                child.stop()
            why = child.verdict()
            if why is not None:
                raise process.RendererError(why)
            self._take(live, size, wish)

    def _take(self, live, size, wish):
        """The picture of the file; one that is not there or of a wrong length is none."""
        try:
            flat = np.fromfile(live, "<f4")
        except OSError:
            return
        width, height = size
        if flat.size == 4 * width * height:
            pixels = np.ascontiguousarray(flat.reshape(height, width, 4)[::-1])
            self._frame = Frame(pixels, self._frame.serial + 1 if self._frame else 1, wish)


def camera_of(projection, to_world, size):
    """A camera record of glTF and its node's matrix (16 numbers, column by column) for a view.

    `projection`: the 4x4 matrix of the view's projection, `to_world`: the 4x4 matrix of its place, `size`: in pixels.
    """
    p, (width, height) = np.asarray(projection, float), size
    record = {"lens": 50.0, "sensorWidth": 36.0, "sensorFit": "horizontal"}
    aspect = width / height
    if p[3, 2] == 0.0:
        # Across the picture there are 2 / p00 metres; its middle is where the projection is 0.
        record.update(type="orthographic", orthoScale=2.0 / p[0, 0])
        middle = (-p[0, 3], -p[1, 3])
        plain = {"type": "orthographic", "orthographic": {"xmag": 1.0 / p[0, 0], "ymag": 1.0 / p[1, 1], "znear": 0.0, "zfar": 1e6}}
    else:
        record.update(type="perspective", lens=18.0 * p[0, 0])
        middle = (p[0, 2], p[1, 2])
        plain = {"type": "perspective", "perspective": {"aspectRatio": aspect, "yfov": 2.0 * float(np.arctan(1.0 / p[1, 1])), "znear": 1e-3}}
    record["shift"] = [float(middle[0]) / 2.0, float(middle[1]) / 2.0 / aspect]
    matrix = np.asarray(to_world, float)
    return {"name": "View", **plain, "extensions": {"RAYLOOM_scene": record}}, [float(matrix[r, c]) for c in range(4) for r in range(4)]


def with_camera(document, camera, matrix):
    """The glTF document seen by another camera; the document itself stays as it is."""
    extension = dict(document["extensions"]["RAYLOOM_scene"])
    nodes = list(document["nodes"])
    cameras = [*document.get("cameras", []), camera]
    nodes.append({"name": "View", "camera": len(cameras) - 1, "matrix": matrix})
    extension["camera"] = len(nodes) - 1
    root = nodes[extension["root"]]
    nodes[extension["root"]] = {**root, "children": [*root.get("children", []), extension["camera"]]}
    return {**document, "nodes": nodes, "cameras": cameras, "extensions": {**document["extensions"], "RAYLOOM_scene": extension}}
