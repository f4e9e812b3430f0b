# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: Blender's shader tree as the file has it, and the glTF material that other programs show."""

import numpy as np

from ..core import pictures
from ..core.atlas import Atlas
from ..core.bake import Baker, linear_to_srgb
from ..core.evaluate import Unknown, affine, srgb_to_linear
from ..core.fallback import gltf_material
from ..core.lower import Lowering
from ..core.schema import NAME
from .image import pixels_of
from .links import output_node
from .mesh import ordered_uvs, positions_of, read_array
from .nodes import Graph


def plain_record(version):
    """The material of surfaces that have none: diffuse, from Blender 5.0 on Principled's defaults. Source: measured, 4.2, 4.5 and 5.0."""
    node = {"type": "principled"} if version >= (5, 0, 0) else {"type": "diffuse", "color": [0.8, 0.8, 0.8]}
    plain = {"baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5 if version >= (5, 0, 0) else 1.0}
    return {"name": "Default", "pbrMetallicRoughness": plain, "extensions": {NAME: {"nodes": [node], "surface": 0}}}


class Surroundings:
    """What there is to bake over: the mesh of one object."""

    def __init__(self, gltf, images, grids, name, mesh, matrix_world):
        self.gltf, self.images, self.grids = gltf, images, grids
        self.name, self.mesh, self.matrix_world = name, mesh, matrix_world
        self.used = False
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
            return affine([v for row in self.matrix_world[:3] for v in row], p)
        raise Unknown(f"coordinates of source {source}")

    def image(self, ix):
        """Linear pixels of a picture."""
        if ix not in self._pixels:
            source = self.images.sources.get(ix)
            pixels = pixels_of(source) if source is not None else None
            if pixels is None:
                raise Unknown("a picture without pixels")
            if not source.is_float and self.images.records[ix]["colorSpace"] == "srgb":
                pixels = np.concatenate([srgb_to_linear(pixels[..., :3]), pixels[..., 3:]], axis=-1)
            self._pixels[ix] = pixels
        return self._pixels[ix]

    def add_picture(self, pixels, is_color):
        """A baked picture: 16-bit PNG of values in 0..1, else floats."""
        if pixels.min() < 0.0 or pixels.max() > 1.0:
            return self.images.add(f"{self.name} (baked)", pictures.exr(pixels), "image/x-exr", "linear", "none")
        data = pictures.png(linear_to_srgb(pixels) if is_color else pixels, 16)
        return self.images.add(f"{self.name} (baked)", data, "image/png", "srgb" if is_color else "nonColor", "none")

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
        vertex = read_array(mesh.loops, "vertex_index", np.int32, 1)[self._corners]
        if source == "normal":
            return self._mixed(read_array(mesh.corner_normals, "vector", np.float32, 3)[self._corners])
        return self.around.points(source, self._mixed(positions_of(mesh)[vertex]))

    def _mixed(self, values):
        """Values (triangles, 3 corners, k) at the samples."""
        triangle, weights, _, _ = self.samples
        out = weights[:, :1] * values[triangle, 0]
        for k in (1, 2):
            out += weights[:, k : k + 1] * values[triangle, k]
        return out


def material_record(material, surroundings, images, uv_names, color_names, log):
    """glTF's record of a material, and whether it names layers of its mesh."""

    def tell(what):
        log(f"Material '{material.name}'", what)

    graph = Graph(images, tell, uv_names, color_names)
    lowering = Lowering(graph.nodes, Baker(surroundings), tell)
    extension = {"nodes": lowering.out}
    tree = material.node_tree if getattr(material, "use_nodes", True) else None
    if tree is None:
        extension["nodes"].append({"type": "principled", "baseColor": list(material.diffuse_color)[:3], "roughness": material.roughness})
        extension["nodes"][0]["metallic"] = material.metallic
        extension["surface"] = 0
    else:
        end = output_node(tree, "OUTPUT_MATERIAL")
        for key, name in (("surface", "Surface"), ("volume", "Volume")):
            k = graph.closure(end.inputs[name]) if end else None
            if k is not None:
                extension[key] = lowering.closure(k)
        if end and end.inputs["Displacement"].is_linked:
            tell("displacement is left out")
    cycles = getattr(material, "cycles", None)
    if cycles is not None:
        sides = {"NONE": "none", "FRONT": "front", "BACK": "back", "FRONT_BACK": "frontBack"}
        sampling = sides.get(getattr(cycles, "emission_sampling", "AUTO"))
        if sampling:
            extension["emissionSampling"] = sampling
        # Gone in 5.0.
        if getattr(cycles, "homogeneous_volume", False):
            extension["homogeneousVolume"] = True
        if getattr(cycles, "volume_step_rate", 1.0) != 1.0:
            extension["volumeStepRate"] = cycles.volume_step_rate
    if not getattr(material, "use_transparent_shadow", True):
        extension["transparentShadow"] = False
    if material.pass_index:
        extension["passIndex"] = material.pass_index
    record = gltf_material(extension, images.records, surroundings.gltf)
    record["name"] = material.name
    record["extensions"] = {**record.get("extensions", {}), NAME: extension}
    return record, graph.names_layers
