#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""core/ of the Blender extension without Blender: `python3 tests/blender/test_core.py`. Needs numpy."""

import json
import os
import struct
import sys
import tempfile
import time
import unittest
import zlib

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "addons"))

from rayloom_blender.core import atlas, bake, baked, corners, decompose, denoiser, evaluate, exr, glb, lower, passes, pictures, process, textures, values, viewport  # noqa: E402


def read_glb(path):
    """JSON and binary chunk."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


class Files(unittest.TestCase):
    def test_a_glb_holds_its_arrays(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.glb")
            g = glb.Gltf("test")
            points = np.arange(12, dtype=np.float32).reshape(4, 3)
            g.accessor(points, glb.ARRAY_BUFFER, bounds=True)
            g.accessor(np.array([1, 2, 3], np.uint8))
            g.accessor(np.array([7], np.uint32))
            g.write(path)
            document, binary = read_glb(path)
            first, second, third = document["accessors"]
            self.assertEqual((first["type"], first["min"], first["max"]), ("VEC3", [0, 1, 2], [9, 10, 11]))
            views = document["bufferViews"]
            self.assertEqual(binary[: views[0]["byteLength"]], points.tobytes())
            self.assertEqual(views[second["bufferView"]]["byteLength"], 3)
            self.assertEqual(views[third["bufferView"]]["byteOffset"] % 4, 0)
            self.assertEqual(document["buffers"][0]["byteLength"], len(binary))
            self.assertEqual(os.listdir(folder), ["a.glb"])

    def test_kept_buffers_are_written_once(self):
        with tempfile.TemporaryDirectory() as folder:
            big = np.arange(1 << 18, dtype=np.uint32)
            written = []
            for frame in range(3):
                g = glb.Gltf("test", keep=os.path.join(folder, "kept"))
                g.accessor(big)
                g.accessor(np.full(3, frame, np.uint32))
                g.write(os.path.join(folder, "a.gltf"))
                written.append(g.written_bytes)
            self.assertGreater(written[0], 1 << 20)
            self.assertLess(max(written[1:]), 1000)
            with open(os.path.join(folder, "a.gltf"), encoding="utf-8") as file:
                document = json.load(file)
            uri = document["buffers"][0]["uri"]
            self.assertEqual(os.path.getsize(os.path.join(folder, uri)), big.nbytes)

    def test_nothing_stays_of_a_file_that_could_not_be_written(self):
        with tempfile.TemporaryDirectory() as folder:
            g = glb.Gltf("test")
            g.document["asset"]["bad"] = float("nan")
            self.assertRaises(ValueError, g.write, os.path.join(folder, "a.glb"))
            self.assertEqual(os.listdir(folder), [])


class Corners(unittest.TestCase):
    def test_corners_share_vertices_but_for_seams(self):
        # Two triangles along an edge; vertex 2 has two values.
        vertex = np.array([0, 1, 2, 2, 1, 3])
        value = np.array([[0], [1], [2], [9], [1], [3]], np.float32)
        source_vertex, source_corner, index = corners.split_corners(vertex, 4, [value])
        self.assertEqual(len(source_vertex), 5)
        np.testing.assert_array_equal(source_vertex[index], vertex)
        np.testing.assert_array_equal(value[source_corner][index], value)


class Decomposition(unittest.TestCase):
    def test_turned_stretched_and_mirrored_matrices_come_apart(self):
        rng = np.random.default_rng(3)
        q = rng.normal(size=(200, 4))
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        q[:4] = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        scale = rng.uniform(0.1, 3.0, (200, 3)) * np.where(rng.random(200) < 0.5, -1.0, 1.0)[:, None]
        m = np.tile(np.eye(4), (200, 1, 1))
        m[:, :3, :3] = decompose._rotations(q) * scale[:, None, :]
        m[:, :3, 3] = rng.normal(size=(200, 3))
        translation, rotation, parts, fits = decompose.trs_of(m)
        self.assertTrue(fits.all())
        again = decompose._rotations(rotation.astype(float)) * parts.astype(float)[:, None, :]
        self.assertLess(np.abs(again - m[:, :3, :3]).max(), 2e-6)
        self.assertLess(np.abs(translation - m[:, :3, 3]).max(), 1e-6)

    def test_sheared_flat_and_broken_matrices_are_told(self):
        m = np.tile(np.eye(4), (4, 1, 1))
        m[1, 0, 1], m[2, 2, 2], m[3, 0, 3] = 0.01, 0.0, np.nan
        with np.errstate(all="ignore"):
            self.assertEqual(decompose.trs_of(m)[3].tolist(), [True, False, False, False])


class Pictures(unittest.TestCase):
    def test_own_exr_is_read_back(self):
        pixels = np.random.default_rng(1).normal(size=(5, 7, 4)).astype(np.float32)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.exr")
            with open(path, "wb") as file:
                file.write(pictures.exr(pixels))
            p = exr.read(path)
            np.testing.assert_array_equal(np.stack([p.channels[c] for c in "RGBA"], axis=-1), pixels)
            with open(path, "r+b") as file:
                file.truncate(300)
            self.assertRaises(exr.Unreadable, exr.read, path)

    def test_zip_is_undone(self):
        raw = np.random.default_rng(2).integers(0, 255, 1001).astype(np.uint8)
        woven = np.concatenate([raw[0::2], raw[1::2]]).astype(np.int64)
        woven[1:] = (woven[1:] - woven[:-1] + 128) % 256
        packed = zlib.compress(woven.astype(np.uint8).tobytes())
        np.testing.assert_array_equal(exr._unzip(packed, 1001), raw)

    def test_png_has_its_depth_and_rows(self):
        data = pictures.png(np.full((2, 3, 3), 0.5), 16)
        self.assertEqual(struct.unpack(">IIBB", data[16:26]), (3, 2, 16, 2))
        self.assertEqual(pictures.mime_of(data), "image/png")


def pixels_of_png(data):
    """Pixels of a 16-bit sRGB PNG of rows without filters, linear."""
    width, height = struct.unpack(">II", data[16:24])
    length = struct.unpack(">I", data[33:37])[0]
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), np.uint8).reshape(height, 1 + 6 * width)[:, 1:]
    return values.srgb_to_linear(np.ascontiguousarray(rows).view(">u2").reshape(height, width, 3) / 65535.0)


class Around:
    """Something to bake over."""

    def __init__(self):
        self.pictures, self.grids = [], []

    def uv_box(self, uv_set):
        return (0.0, 0.0), (1.0, 2.0)

    def body(self):
        return np.zeros(3), np.array([2.0, 1.0, 1.0])

    def points(self, source, p):
        return p

    def image(self, ix):
        raise values.Unknown("image")

    def about(self, node, output):
        raise values.Unknown(node["type"])

    log = print

    def shape(self, nodes):
        return [np.arange(3)]

    def add_file(self, data, mime, space):
        self.pictures.append(pixels_of_png(data))
        return len(self.pictures) - 1

    def add_grid(self, values, resolution, body):
        self.grids.append(values.reshape(resolution[::-1]))
        return len(self.grids) - 1


class Textures(unittest.TestCase):
    def test_values_are_those_measured_in_blender(self):
        # By geometry nodes of bpy 4.5.15 (pcg: 5.0.1) at two points; tests/blender/trees.py has hundreds more, for where Blender is.
        points = np.array([(0.3, 0.7, 1.9), (-2.6, 0.1, 0.4)], np.float32)
        measured = (
            ({"type": "noise", "scale": 2.0, "dimensions": 4, "w": 0.7, "distortion": 0.5}, "color", [[0.36437, 0.5012, 0.5447], [0.50396, 0.40916, 0.50153]]),
            ({"type": "noise", "kind": "ridgedMultifractal", "scale": 2.0, "dimensions": 2, "offset": 0.8, "gain": 1.2}, "fac", [0.11573, 0.52641]),
            ({"type": "voronoi", "hash": "jenkins", "scale": 2.0}, "color", [[0.48047, 0.60001, 0.0286], [0.12301, 0.98637, 0.95256]]),
            ({"type": "voronoi", "hash": "jenkins", "scale": 2.0, "feature": "smoothF1", "metric": "manhattan", "smoothness": 0.7}, "distance", [0.44817, 0.54712]),
            ({"type": "voronoi", "hash": "jenkins", "scale": 2.0, "feature": "distanceToEdge", "dimensions": 2, "detail": 1.5, "normalize": True}, "distance", [0.17043, 0.07648]),
            ({"type": "wave", "scale": 1.5, "kind": "rings", "direction": "z", "profile": "tri", "distortion": 2.0}, "fac", [0.84152, 0.97818]),
            ({"type": "magic", "scale": 1.5, "depth": 5, "distortion": 1.3}, "color", [[0.73932, 0.96646, 0.08529], [0.9881, 0.35875, 0.9909]]),
            ({"type": "brick", "scale": 2.0, "color1": [1, 0, 0], "color2": [0, 1, 0], "mortar": [0, 0, 1], "mortarSize": 0.05, "mortarSmooth": 0.5, "bias": 0.1, "offset": 0.5, "offsetFrequency": 2, "squash": 0.8, "squashFrequency": 3}, "color", [[0.17544, 0.82456, 0.0], [0.17011, 0.82989, 0.0]]),
            ({"type": "voronoi", "hash": "pcg", "scale": 2.0}, "color", [[0.48369, 0.06545, 0.55363], [0.20645, 0.17421, 0.54044]]),
            ({"type": "voronoi", "hash": "pcg", "scale": 2.0, "feature": "smoothF1", "metric": "manhattan", "smoothness": 0.7}, "distance", [0.61355, 0.64655]),
            ({"type": "voronoi", "hash": "pcg", "scale": 2.0, "feature": "distanceToEdge", "dimensions": 2, "detail": 1.5, "normalize": True}, "distance", [0.11898, 0.16492]),
        )
        for node, output, expected in measured:
            value = evaluate.Evaluator([node], lambda source, uv: points).value({"node": 0, "output": output})
            np.testing.assert_allclose(value, expected, atol=2e-5, err_msg=repr(node))


class Rays(unittest.TestCase):
    def test_a_shader_that_asks_for_the_ray_is_mixed_of_what_each_ray_sees(self):
        nodes = [
            {"type": "lightPath"},
            {"type": "math", "operation": "multiply", "a": {"node": 0, "output": "isCameraRay"}, "b": 4.0},
            {"type": "emission", "color": [1, 1, 1], "strength": {"node": 1}},
        ]
        told = []
        lowering = lower.Lowering(nodes, bake.Baker(Around()), told.append)
        out = lowering.out
        root = out[lowering.surface(2)]
        self.assertEqual((root["type"], out[root["a"]]["strength"], out[root["b"]]["strength"], told), ("mix", 0.0, 4.0, []))
        self.assertEqual(out[root["factor"]["node"]], {"type": "lightPath", "camera": 1.0})


class Atlases(unittest.TestCase):
    def test_no_triangle_writes_into_another_and_all_that_is_mixed_is_its_own(self):
        sides, atlas.SIDES = atlas.SIDES, (64, 128)
        self.addCleanup(setattr, atlas, "SIDES", sides)
        borders = set()
        # Cells from 64 texels down to the least.
        for n in (1, 2, 9, 40, 120, 500, 800, 1200):
            a = atlas.Atlas(n)
            self.assertTrue(a.fits)
            borders.add(a.border)
            triangle, weights, rows, columns = a.samples()
            place = rows * a.side + columns
            self.assertEqual(len(np.unique(place)), len(place), n)
            self.assertTrue((rows >= 0).all() and (rows < a.side).all() and (columns >= 0).all() and (columns < a.side).all())
            owner = np.full((a.side, a.side), -1)
            owner[rows, columns] = triangle
            uv = a.corner_uv()
            # Points of the triangles, and half a texel off where there is a border, are mixed of texels of their own.
            rng = np.random.default_rng(1)
            w = rng.dirichlet((1, 1, 1), (n, 4))
            at = np.einsum("nkc,ncx->nkx", w, uv)
            for dx, dy in ((0, 0), (0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5)) if a.border else ((0, 0),):
                x, y = at[..., 0] * a.side - 0.5 + dx, (1.0 - at[..., 1]) * a.side - 0.5 + dy
                for i in (np.floor(x + 1e-3), np.ceil(x - 1e-3)):
                    for j in (np.floor(y + 1e-3), np.ceil(y - 1e-3)):
                        self.assertTrue((owner[j.astype(int), i.astype(int)] == np.arange(n)[:, None]).all(), (n, dx, dy))
        self.assertEqual(borders, {0, 1})
        self.assertFalse(atlas.Atlas(2000).fits)


class Shaders(unittest.TestCase):
    def lowered(self, nodes):
        around, told = Around(), []
        lowering = lower.Lowering(nodes, bake.Baker(around), told.append)
        return lowering.out[lowering.closure(len(nodes) - 1)], lowering.out, around, told

    def test_constants_are_folded(self):
        nodes = [
            {"type": "math", "operation": "multiply", "a": 0.5, "b": 0.5},
            {"type": "diffuse", "color": [1, 0, 0], "roughness": {"node": 0}},
        ]
        closure, out, _, told = self.lowered(nodes)
        self.assertEqual((closure["roughness"], len(out), told), (0.25, 1, []))

    def test_checkers_become_a_texel_a_cell(self):
        where = {"source": "uv", "affine": [2, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0]}
        nodes = [
            {"type": "checker", "coordinates": where, "scale": 3.0, "color1": [1, 0, 0], "color2": [0, 0, 1]},
            {"type": "diffuse", "color": {"node": 0, "output": "color"}},
        ]
        closure, out, around, told = self.lowered(nodes)
        image = out[closure["color"]["node"]]
        self.assertEqual((image["type"], image["interpolation"], told), ("image", "closest", []))
        # u from 0.5 to 2.5 times 3, v from 0 to 2 times 3.
        self.assertEqual(around.pictures[0].shape, (6, 7, 3))
        a = np.array(image["coordinates"]["affine"]).reshape(3, 4)
        rng = np.random.default_rng(4)
        uv = np.column_stack([rng.random(200), 2 * rng.random(200), np.zeros(200)])
        direct = evaluate.Evaluator(nodes, lambda source, k: uv).value({"node": 0, "output": "color"})
        at = uv @ a[:, :3].T + a[:, 3]
        baked = textures.sample(around.pictures[0], at[:, 0], at[:, 1], "extend", True)
        np.testing.assert_allclose(baked, direct, atol=1e-6)

    def test_pictures_keep_their_texels_and_repeat(self):
        picture = np.random.default_rng(5).random((32, 1200, 4)).astype(np.float32)
        twice = [2, 0, 0, 0.25, 0, 1, 0, 0, 0, 0, 1, 0]
        for affine, extension, width, again in ((None, "repeat", 1200, "repeat"), (twice, "repeat", 2400, "repeat"), (None, "extend", 1200, "extend")):
            where = {"source": "uv", **({"affine": affine} if affine else {})}
            nodes = [
                {"type": "image", "image": 0, "coordinates": where, "extension": extension},
                {"type": "invert", "color": {"node": 0, "output": "color"}},
                {"type": "diffuse", "color": {"node": 1}},
            ]
            around, told = Around(), []
            around.image = lambda ix: picture
            lowering = lower.Lowering(nodes, bake.Baker(around), told.append)
            closure = lowering.out[lowering.closure(2)]
            image, baked_picture = lowering.out[closure["color"]["node"]], around.pictures[0]
            # The box of coordinates is one unit wide and two high.
            self.assertEqual((image["extension"], baked_picture.shape[1]), (again, width))
            rng = np.random.default_rng(6)
            uv = np.column_stack([rng.random(50), 2 * rng.random(50), np.zeros(50)])
            direct = evaluate.Evaluator(nodes, lambda source, k: uv, around.image).value({"node": 1})
            at = values.affine(image["coordinates"].get("affine", np.eye(3, 4).ravel()), uv)
            shown = textures.sample(baked_picture, at[:, 0], at[:, 1], again, False)
            self.assertLess(np.abs(shown - direct).mean(), 0.02)

    def test_a_bake_is_kept_until_something_changes(self):
        baked.forget()
        counted, encoded = [], bake.encoded
        bake.encoded = lambda *a: (counted.append(1), encoded(*a))[1]
        try:
            for scale in (3.0, 3.0, 4.0):
                node = {"type": "wave", "coordinates": {"source": "uv"}, "scale": scale, "kind": "bands", "direction": "x", "profile": "sin"}
                self.lowered([node, {"type": "diffuse", "color": {"node": 0, "output": "color"}}])
        finally:
            bake.encoded = encoded
        self.assertEqual(len(counted), 2)

    def test_densities_become_grids(self):
        nodes = [
            {"type": "gradient", "coordinates": {"source": "object"}, "kind": "linear"},
            {"type": "math", "operation": "multiply", "a": {"node": 0, "output": "fac"}, "b": 4.0},
            {"type": "principledVolume", "density": {"node": 1}},
        ]
        closure, out, around, told = self.lowered(nodes)
        self.assertEqual(out[closure["density"]["node"]], {"type": "grid", "grid": 0})
        grid = around.grids[0]
        # Linear but for its ends, where the gradient is cut off: the coarsest grid does.
        self.assertEqual(grid.shape, (10, 10, 20))
        self.assertAlmostEqual(float(grid[0, 0, 5]), 4 * 5.5 / 10, places=4)
        self.assertEqual(len(told), 1)

    def test_grids_are_as_fine_as_the_density_asks(self):
        where = {"source": "object"}
        nodes = [{"type": "checker", "coordinates": where, "scale": 3.0}, {"type": "principledVolume", "density": {"node": 0, "output": "fac"}}]
        _, _, around, _ = self.lowered(nodes)
        self.assertEqual(max(around.grids[0].shape), 160)

    def test_trilinear_meets_the_centres_and_lies_between(self):
        values = np.random.default_rng(2).random((3, 4, 5))
        z, y, x = np.indices(values.shape).reshape(3, -1)
        centres = (np.stack([x, y, z], -1) + 0.5) / [5, 4, 3]
        np.testing.assert_allclose(bake.trilinear(values, centres), values.ravel())
        between = bake.trilinear(values, np.array([[0.2, 0.5 / 4, 0.5 / 3]]))
        np.testing.assert_allclose(between, (values[0, 0, 0] + values[0, 0, 1]) / 2)

    def test_lines_of_channels_stay(self):
        nodes = [
            {"type": "image", "image": 0, "coordinates": {"source": "uv"}},
            {"type": "separate", "color": {"node": 0, "output": "color"}},
            {"type": "math", "operation": "subtract", "a": 1.0, "b": {"node": 1, "output": "y"}},
            {"type": "principled", "roughness": {"node": 2}, "baseColor": {"node": 0, "output": "color"}},
        ]
        closure, out, around, told = self.lowered(nodes)
        self.assertEqual((out[closure["roughness"]["node"]]["type"], around.pictures, told), ("math", [], []))


class Denoiser(unittest.TestCase):
    """Blender's own library."""

    def test_the_library_is_found_where_blender_keeps_it(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertIsNone(denoiser.find(folder, os.path.join(folder, "blender")))
            os.mkdir(os.path.join(folder, "lib"))
            names = {"win32": "OpenImageDenoise.dll", "darwin": "libOpenImageDenoise.2.dylib"}
            path = os.path.join(folder, "lib", names.get(sys.platform, "libOpenImageDenoise.so.2"))
            open(path, "w").close()
            self.assertEqual(denoiser.find(folder), path)
            self.assertEqual(os.path.realpath(denoiser.find("", os.path.join(folder, "blender"))), os.path.realpath(path))


class FakeRenderer:
    """A renderer that makes one picture after the other, of the number of its start, until it is stopped or has made `n`."""

    started, stopped = [], []

    def __init__(self, command, folder):
        self.live, self.size, self.n, self.value = command["live"], command["size"], command["n"], len(self.started) + 1
        self.started.append(self)

    def running(self):
        return self.n > 0

    def events(self):
        if self.n == 0:
            return []
        self.n -= 1
        np.full((self.size[1], self.size[0], 4), self.value, "<f4").tofile(self.live)
        return [{"event": "picture"}]

    def wait_readers(self):
        pass

    def stop(self):
        self.stopped.append(self)

    def verdict(self):
        return None if self.value < 100 else "it broke"


class Viewport(unittest.TestCase):
    """The thread that keeps a renderer busy."""

    def setUp(self):
        FakeRenderer.started, FakeRenderer.stopped = [], []
        self.folder = tempfile.TemporaryDirectory()
        self.session = viewport.Session(self.folder.name, start=FakeRenderer)

    def tearDown(self):
        self.session.close()
        self.session.join(5.0)
        self.folder.cleanup()

    def wish(self, n):
        command = lambda path, live, size, samples: {"live": live, "size": size, "n": n}  # noqa: E731
        return viewport.Wish((64, 32), 16, lambda path: None, command)

    def until(self, what, seconds=5.0):
        end = time.monotonic() + seconds
        while not what() and time.monotonic() < end:
            time.sleep(0.005)
        self.assertTrue(what())

    def test_small_pictures_come_first_then_whole_ones(self):
        self.session.show(self.wish(2))
        self.until(lambda: not self.session.busy())
        self.assertEqual([r.size for r in FakeRenderer.started], [(16, 8), (64, 32)])
        frame = self.session.frame()
        self.assertEqual((frame.pixels.shape, float(frame.pixels[0, 0, 0]), self.session.error()), ((32, 64, 4), 2.0, None))

    def test_a_change_ends_the_renderer_and_never_waits(self):
        self.session.show(self.wish(10**9))
        self.until(lambda: self.session.frame() is not None)
        start = time.monotonic()
        self.session.show(self.wish(1))
        self.assertLess(time.monotonic() - start, 0.1)
        self.until(lambda: not self.session.busy())
        self.assertEqual(len(FakeRenderer.stopped), 3)
        self.assertEqual(float(self.session.frame().pixels[0, 0, 0]), 3.0)

    def test_errors_are_told_and_the_next_wish_is_served(self):
        broken = self.wish(1)
        broken.write = lambda path: (_ for _ in ()).throw(OSError("no room"))
        self.session.show(broken)
        self.until(lambda: not self.session.busy())
        self.assertEqual(self.session.error(), "no room")
        self.session.show(self.wish(1))
        self.until(lambda: not self.session.busy())
        self.assertIsNone(self.session.error())

    def test_closing_ends_a_running_renderer(self):
        self.session.show(self.wish(10**9))
        self.until(lambda: self.session.frame() is not None)
        self.session.close()
        self.session.join(5.0)
        self.assertEqual(len(FakeRenderer.stopped), len(FakeRenderer.started))

    def test_a_projection_becomes_a_camera(self):
        # 90 degrees across 2:1, the middle of the picture to the right by a tenth of its width.
        p = [[1.0, 0, 0.2, 0], [0, 2.0, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]]
        camera, matrix = viewport.camera_of(p, np.eye(4), (200, 100))
        own = camera["extensions"]["RAYLOOM_scene"]
        self.assertEqual((own["lens"], own["shift"]), (18.0, [0.1, 0.0]))
        p = [[0.5, 0, 0, 0], [0, 1.0, 0, 0.5], [0, 0, -0.1, 0], [0, 0, 0, 1]]
        own = viewport.camera_of(p, np.eye(4), (200, 100))[0]["extensions"]["RAYLOOM_scene"]
        self.assertEqual((own["type"], own["orthoScale"], own["shift"]), ("orthographic", 4.0, [0.0, -0.125]))
        document = {"nodes": [{"name": "root"}], "extensions": {"RAYLOOM_scene": {"root": 0}}}
        seen = viewport.with_camera(document, camera, matrix)
        self.assertEqual((seen["extensions"]["RAYLOOM_scene"]["camera"], seen["nodes"][0]["children"]), (1, [1]))
        self.assertNotIn("children", document["nodes"][0])


class Passes(unittest.TestCase):
    """Names of passes, and Cryptomatte's header."""

    def test_planes_are_found_by_blenders_names(self):
        names = ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Combined.A", "ViewLayer.Depth.Z"]
        names += [f"ViewLayer.CryptoObject00.{c}" for c in "rgba"]
        picture = exr.Picture(1, 1, {name: np.full((1, 1), k) for k, name in enumerate(names)}, {})
        self.assertEqual([int(p[0, 0]) for p in passes.find(picture, "Combined", "RGBA")], [0, 1, 2, 3])
        self.assertEqual([int(p[0, 0]) for p in passes.find(picture, "CryptoObject00", "rgba")], [5, 6, 7, 8])
        self.assertEqual([int(p[0, 0]) for p in passes.find(picture, "Depth", "Z")], [4])
        self.assertIsNone(passes.find(picture, "Mist", "Z"))
        plain = exr.Picture(1, 1, {c: np.full((1, 1), k) for k, c in enumerate("RGB")}, {})
        self.assertEqual([int(p[0, 0]) for p in passes.find(plain, "Combined", "RGBA")], [0, 1, 2, 1])

    def test_cryptomatte_takes_the_view_layers_name(self):
        header = {
            "cryptomatte/abc1234/name": b"ViewLayer.CryptoObject",
            "cryptomatte/abc1234/manifest": b'{"A":"1"}',
            "cryptomatte/abc1234/hash": b"MurmurHash3_32",
            "compression": b"",
        }
        fields = passes.cryptomatte_fields(header, "Main")
        names = [k for k, v in fields.items() if v == "Main.CryptoObject"]
        self.assertEqual((len(names), len(fields)), (1, 3))
        self.assertEqual(fields[names[0].replace("/name", "/manifest")], '{"A":"1"}')

    def test_two_ranks_are_a_layer(self):
        self.assertEqual(passes.registered(["objectId", "depth"], version=(5, 0, 1))[1:], [("Object Index", "X", "VALUE"), ("Depth", "Z", "VALUE")])
        names = [n for n, _, _ in passes.registered(["cryptoObject", "depth", "nothing"], 3)]
        self.assertEqual(names, ["Combined", "CryptoObject00", "CryptoObject01", "Depth"])


RENDERER = """
import json, sys, time
print(json.dumps({"event": "rendering", "device": "test"}), flush=True)
print("no JSON", flush=True)
sys.stderr.write("error: all is lost\\n"); sys.stderr.flush()
time.sleep(float(sys.argv[1]))
sys.exit(int(sys.argv[2]))
"""


class Process(unittest.TestCase):
    def run_renderer(self, seconds, code, cancelled=lambda: False):
        events = []
        renderer = process.Renderer([sys.executable, "-c", RENDERER, str(seconds), str(code)], None)
        return process.drive(renderer, events.append, cancelled), events, renderer

    def test_events_arrive_and_success_is_true(self):
        done, events, _ = self.run_renderer(0.2, 0)
        self.assertTrue(done)
        self.assertEqual(events, [{"event": "rendering", "device": "test"}])

    def test_failure_says_what_was_said(self):
        with self.assertRaisesRegex(process.RendererError, "found the scene wrong.*all is lost"):
            self.run_renderer(0.1, 3)

    def test_cancel_ends_it_at_once(self):
        start = time.monotonic()
        done, _, renderer = self.run_renderer(30, 0, lambda: time.monotonic() - start > 0.3)
        self.assertFalse(done or renderer.running())
        self.assertLess(time.monotonic() - start, 0.8)

    def test_a_missing_program_is_an_error_in_words(self):
        with self.assertRaisesRegex(process.RendererError, "cannot be started"):
            process.Renderer(["/nowhere/rayloom"], None)


if __name__ == "__main__":
    unittest.main()
