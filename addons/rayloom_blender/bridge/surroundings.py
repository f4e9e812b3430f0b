# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials are baked over: the mesh of an object, its faces one by one, and what nodes ask of the object."""

import numpy as np

from ..core.atlas import Atlas
from ..core.schema import is_link
from ..core.values import Unknown, affine
from .image import linear_pixels
from .mesh import ordered_colors, ordered_uvs, positions_of, read_array


# Nodes whose values are more than the mesh's shape.
_ASKING = {"image", "attribute", "meshAttribute", "objectAttribute", "objectInfo", "geometry"}


# Most sorts of instances that a random number makes of one object, and triangles of all together. Picked by feel.
RANDOM_STEPS, RANDOM_TRIANGLES = 16, 2_000_000


def random_steps(mesh):
    """Into how many steps random numbers of a mesh's instances are rounded: every step is a mesh of its own."""
    return max(1, min(RANDOM_STEPS, RANDOM_TRIANGLES // max(1, 2 * len(mesh.polygons)))) if mesh is not None else 1


def step_of(shown, mesh):
    """The step of an instance; `None` of an object that is none."""
    steps = random_steps(mesh)
    return min(int(shown.random * steps), steps - 1) if shown.key[3] else None


class Surroundings:
    """What there is to bake over: the mesh of one object.

    `used`: something was asked of the mesh; `placed`: of the object, so that another with the same mesh shows something else; `varied`: of the
    instance, likewise.
    """

    def __init__(self, gltf, images, grids, material, mesh, shown, log):
        self.gltf, self.images, self.grids = gltf, images, grids
        self.material, self.mesh, self.shown, self.log = material, mesh, shown, log
        self.used = self.placed = self.varied = False
        self._pixels = {}
        self.baked_surface = None

    def uv_box(self, uv_set):
        """Least box around the coordinates of a UV layer."""
        layers = ordered_uvs(self.mesh) if self.mesh else []
        if uv_set >= len(layers):
            return None
        self.used = True
        uv = read_array(layers[uv_set].uv, "vector", np.float32, 2)
        return (tuple(map(float, uv.min(axis=0))), tuple(map(float, uv.max(axis=0)))) if len(uv) else None

    def body(self):
        """Box of the mesh in its own space."""
        if self.mesh is None or not len(self.mesh.vertices):
            return None
        self.used = True
        p = positions_of(self.mesh)
        return p.min(axis=0).astype(float), p.max(axis=0).astype(float)

    def surface(self):
        """Places for all faces of the mesh in a picture; `None` without faces, or with too many."""
        self.used = True
        if self.baked_surface is None and self.mesh is not None:
            surface = Surface(self)
            self.baked_surface = surface if surface.atlas.fits else None
        return self.baked_surface

    def points(self, source, p):
        """Coordinates of a source at points of the object's space."""
        self.used = True
        if source == "object":
            return p
        if source == "generated":
            size = np.maximum(np.abs(np.array(self.mesh.texspace_size)), 1e-9)
            return (p - np.array(self.mesh.texspace_location)) / (2.0 * size) + 0.5
        if source == "position":
            self.placed = True
            if self.shown.key[3]:
                self.log("all instances are baked where the first stands")
            return affine([v for row in self.shown.matrix[:3] for v in row], p)
        raise Unknown(f"coordinates of source {source}")

    def about(self, node, output):
        """What a node tells of the object, or of a ray: the same at all points."""
        self.used = True
        kind = node["type"]
        if kind == "objectInfo":
            return self._object_info(output)
        if kind == "objectAttribute":
            self.placed = True
            value = self.shown.obj.get(node["name"], 0.0)
            value = list(value)[:3] if hasattr(value, "__len__") and not isinstance(value, str) else value
            return value if isinstance(value, list) and len(value) == 3 else [float(value)] * 3 if isinstance(value, (int, float)) else [0.0] * 3
        if kind == "lightPath":
            self.log("the Light Path node is taken as for rays from the camera")
            return 1.0 if output == "isCameraRay" else 0.0
        if kind == "layerWeight" or kind == "fresnel":
            self.log(f"the {'Fresnel' if kind == 'fresnel' else 'Layer Weight'} node is taken at its mean angle")
            return seen_at_mean_angle(node, output)
        if kind == "curvesInfo":
            along = np.linspace(0.0, 1.0, 64, dtype=np.float32)
            hair = {"intercept": along, "random": (along * 63 * 0.618034) % 1.0, "isStrand": 1.0}
            return hair.get(output, 0.0) if self.mesh is None else 0.0
        if kind == "geometry" and output == "backfacing":
            return 0.0
        raise Unknown(kind)

    def _object_info(self, output):
        obj = self.shown.obj
        self.placed = True
        if output == "random":
            self.varied = bool(self.shown.key[3])
            if not self.varied:
                return self.shown.random
            steps = random_steps(self.mesh)
            self.log(f"random numbers of instances are rounded to {steps} steps")
            return (step_of(self.shown, self.mesh) + 0.5) / steps
        if output == "materialIndex":
            return float(self.material.pass_index)
        return {
            "color": lambda: list(obj.color)[:3],
            "alpha": lambda: obj.color[3],
            "objectIndex": lambda: float(obj.pass_index),
            "location": lambda: [row[3] for row in self.shown.matrix[:3]],
        }[output]()

    def image(self, ix):
        """Linear pixels of a picture."""
        if ix not in self._pixels:
            self._pixels[ix] = linear_pixels(self.images, ix)
        if self._pixels[ix] is None:
            raise Unknown("a picture without pixels")
        return self._pixels[ix]

    def shape(self, nodes):
        """All that nodes ask of the mesh, as arrays; `None` where they ask for more than its shape and its coordinates."""
        sources = {n["coordinates"]["source"] for n in nodes if "source" in (n.get("coordinates") or {})}
        if self.mesh is None or not sources <= {"uv", "generated", "object"} or any(n["type"] in _ASKING for n in nodes):
            return None
        mesh = self.mesh
        out = [tuple(mesh.texspace_location), tuple(mesh.texspace_size), read_array(mesh.loops, "vertex_index", np.int32, 1), positions_of(mesh)]
        out.append(read_array(mesh.polygons, "loop_start", np.int32, 1))
        return out + [read_array(layer.uv, "vector", np.float32, 2) for layer in (ordered_uvs(mesh) if "uv" in sources else ())]

    def add_file(self, data, mime, space):
        """A baked picture's file; its index."""
        return self.images.add(f"{self.material.name} (baked)", data, mime, space, "none")

    def add_grid(self, values, resolution, body):
        """A density grid over a box of the object's space."""
        low, high = body
        size = high - low
        rows = [size[0], 0, 0, low[0], 0, size[1], 0, low[1], 0, 0, size[2], low[2]]
        record = {"bufferView": self.gltf.view(values), "resolution": [int(n) for n in resolution], "components": 1}
        self.grids.append({**record, "affine": [float(v) for v in rows]})
        return len(self.grids) - 1


class Surface:
    """The faces of a mesh, each with its place in a picture."""

    def __init__(self, around):
        self.around = around
        mesh = around.mesh
        mesh.calc_loop_triangles()
        self.atlas = Atlas(len(mesh.loop_triangles))
        # The set after the mesh's own.
        self.uv_set = len(mesh.uv_layers)
        if self.atlas.fits:
            self.samples = self.atlas.samples()
            self._corners = read_array(mesh.loop_triangles, "loops", np.int32, 3)

    def points(self, source, uv_set):
        """Coordinates of a source at all samples, (n, 3)."""
        mesh = self.around.mesh
        if source == "uv":
            uv = read_array(ordered_uvs(mesh)[uv_set].uv, "vector", np.float32, 2)[self._corners] if uv_set < self.uv_set else 0.0
            return np.pad(self._mixed(uv), ((0, 0), (0, 1))) if uv_set < self.uv_set else np.zeros((len(self.samples[0]), 3))
        vertex = self._vertices()
        if source == "normal":
            return self._mixed(read_array(mesh.corner_normals, "vector", np.float32, 3)[self._corners])
        return self.around.points(source, self._mixed(positions_of(mesh)[vertex]))

    def _vertices(self):
        return read_array(self.around.mesh.loops, "vertex_index", np.int32, 1)[self._corners]

    def about(self, node, output):
        """What a node tells of the surface at all samples."""
        if node["type"] == "attribute":
            names = ordered_colors(self.around.mesh)
            k = int(node["name"].removeprefix("COLOR_"))
            if k >= len(names):
                raise Unknown("a colour attribute that is not there")
            return self._attribute(names[k], output)
        if node["type"] == "meshAttribute":
            attribute = self.around.mesh.attributes.get(node["name"])
            return self._attribute(attribute, output) if attribute is not None else np.zeros((len(self.samples[0]), 3), np.float32)
        if node["type"] == "geometry" and output in {"position", "normal"}:
            if output == "position":
                return self.points("position", 0)
            turn = np.array(self.around.shown.matrix)[:3, :3]
            self.around.placed = True
            n = self.points("normal", 0) @ np.linalg.pinv(turn)
            return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-9)
        return self.around.about(node, output)

    def _attribute(self, attribute, output):
        """Values of an attribute at all samples, (n, 3); as numbers for `fac` and `alpha`."""
        values = attribute_values(attribute)
        where = {"POINT": self._vertices, "CORNER": lambda: self._corners, "FACE": self._polygons}.get(attribute.domain)
        if values is None or where is None:
            raise Unknown(f"the attribute '{attribute.name}' of type {attribute.data_type} on {attribute.domain}")
        mixed = self._mixed(values[where()].astype(np.float32))
        if output == "alpha":
            return mixed[:, 3] if mixed.shape[1] == 4 else np.ones(len(mixed), np.float32)
        color = mixed[:, :3] if mixed.shape[1] >= 3 else np.pad(mixed, ((0, 0), (0, 1))) if mixed.shape[1] == 2 else np.repeat(mixed, 3, axis=1)
        return color.mean(axis=1) if output == "fac" else color

    def _polygons(self):
        return np.repeat(read_array(self.around.mesh.loop_triangles, "polygon_index", np.int32, 1)[:, None], 3, axis=1)

    def _mixed(self, values):
        """Values (triangles, 3 corners, k) at the samples."""
        triangle, weights, _, _ = self.samples
        out = weights[:, :1] * values[triangle, 0]
        for k in (1, 2):
            out += weights[:, k : k + 1] * values[triangle, k]
        return out


# Keys of attributes' values and how many numbers each has, by their types.
_ATTRIBUTES = {
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "INT8": ("value", np.int8, 1),
    "BOOLEAN": ("value", bool, 1),
    "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color", np.float32, 4),
}


def attribute_values(attribute):
    """Numbers of an attribute of any domain, (n, k); `None` for types that are no numbers."""
    if attribute.data_type not in _ATTRIBUTES:
        return None
    values = read_array(attribute.data, *_ATTRIBUTES[attribute.data_type])
    return values if values.ndim == 2 else values[:, None]


def seen_at_mean_angle(node, output):
    """Fresnel or Layer Weight at a cosine of 2/3, the mean over a ball's disk."""
    cosine = 2.0 / 3.0
    if node["type"] == "layerWeight" and output == "facing":
        blend = min(max(float(node.get("blend", 0.5)) if not is_link(node.get("blend", 0.5)) else 0.5, 0.0), 1.0 - 1e-5)
        return 1.0 - cosine ** (2.0 * blend if blend < 0.5 else 0.5 / (1.0 - blend))
    given = node.get("ior" if node["type"] == "fresnel" else "blend", 1.5 if node["type"] == "fresnel" else 0.5)
    given = 0.5 if is_link(given) else float(given)
    eta = max(given, 1e-5) if node["type"] == "fresnel" else 1.0 / max(1.0 - given, 1e-5)
    g = eta * eta - 1.0 + cosine * cosine
    if g <= 0.0:
        return 1.0
    g = g**0.5
    a, b = (g - cosine) / (g + cosine), (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0)
    return 0.5 * a * a * (1.0 + b * b)
