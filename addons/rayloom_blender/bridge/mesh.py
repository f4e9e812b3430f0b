# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: triangles with normals, all UV layers and colour attributes, one primitive a material."""

import numpy as np

from ..core.corners import split_corners
from ..core.glb import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER
from ..core.schema import NAME


def read_array(collection, key, dtype, width):
    """`foreach_get` into a new array of shape (n,) or (n, width)."""
    out = np.empty(len(collection) * width, dtype)
    if len(out):
        collection.foreach_get(key, out)
    return out if width == 1 else out.reshape(-1, width)


def positions_of(mesh):
    """Vertices in the object's space, (n, 3)."""
    attribute = mesh.attributes.get("position")
    if attribute is not None and attribute.data_type == "FLOAT_VECTOR":
        return read_array(attribute.data, "vector", np.float32, 3)
    return read_array(mesh.vertices, "co", np.float32, 3)


def _corner_colors(mesh, attribute, corner_vertex):
    colors = read_array(attribute.data, "color", np.float32, 4)
    return colors if attribute.domain == "CORNER" else colors[corner_vertex]


def ordered_uvs(mesh):
    """UV layers, the one that renders first."""
    return sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)


def ordered_colors(mesh):
    """Colour attributes, the one that renders first."""
    first = mesh.color_attributes.render_color_index
    known = [(k != first, k, a) for k, a in enumerate(mesh.color_attributes) if a.domain in {"CORNER", "POINT"}]
    return [a for _, _, a in sorted(known, key=lambda item: item[:2])]


def normals_of(mesh, domain):
    """Normals of vertices (domain POINT) or corners (CORNER), or `None` where faces are flat."""
    if domain == "POINT":
        return read_array(mesh.vertex_normals, "vector", np.float32, 3)
    return read_array(mesh.corner_normals, "vector", np.float32, 3) if domain == "CORNER" else None


def layout_of(mesh):
    """What moves no vertex: triangles and how corners share vertices, with the attributes; `None` without triangles.

    A dictionary: `source_vertex`, `source_corner` (that of corners alone), `domain` of the normals, `indices` (triangles, 3), `polygon` of each triangle, `normals` or `None` where all faces are
    flat, `uvs` and `colors` as lists of (name, array).
    """
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        return None
    corners = read_array(mesh.loop_triangles, "loops", np.int32, 3)
    polygon = read_array(mesh.loop_triangles, "polygon_index", np.int32, 1)
    corner_vertex = read_array(mesh.loops, "vertex_index", np.int32, 1)
    n_vertices = len(mesh.vertices)
    domain = mesh.normals_domain
    own_normals = normals_of(mesh, domain)
    corner_normals = own_normals if domain == "CORNER" else None
    uvs = [(layer.name, read_array(layer.uv, "vector", np.float32, 2)) for layer in ordered_uvs(mesh)]
    colors = [(a.name, _corner_colors(mesh, a, corner_vertex)) for a in ordered_colors(mesh)]
    attributes = [a for _, a in uvs + colors]
    if corner_normals is not None:
        attributes.append(corner_normals)
    source_vertex, source_corner, corner_index = split_corners(corner_vertex, n_vertices, attributes)
    if domain == "POINT":
        normals = own_normals[source_vertex]
    elif domain == "CORNER":
        normals = corner_normals[source_corner]
    else:
        normals = None
    return {
        "source_vertex": source_vertex,
        "source_corner": source_corner,
        "domain": domain,
        "indices": corner_index[corners],
        "polygon": polygon,
        "normals": normals,
        "uvs": [(name, a[source_corner]) for name, a in uvs],
        "colors": [(name, a[source_corner]) for name, a in colors],
    }


def _unshared(layout, corner_uv):
    """The layout with vertices of its own for every corner, and one more set of coordinates, (triangles, 3, 2)."""
    flat = layout["indices"].ravel()
    gather = lambda rows: [(name, a[flat]) for name, a in rows]  # noqa: E731
    return {
        **layout,
        "source_vertex": layout["source_vertex"][flat],
        "source_corner": layout["source_corner"][flat],
        "indices": np.arange(len(flat), dtype=np.uint32).reshape(-1, 3),
        "normals": None if layout["normals"] is None else layout["normals"][flat],
        **({"offsets": layout["offsets"][flat]} if "offsets" in layout else {}),
        "uvs": [*gather(layout["uvs"]), ("baked", corner_uv.reshape(-1, 2))],
        "colors": gather(layout["colors"]),
    }


def write_mesh(gltf, mesh, materials, name, corner_uv=None, displace=None):
    """Adds a mesh; `(index, layout)`, or `None` when it has no triangles.

    `materials`: glTF's index, or `None`, for each material slot. `corner_uv`: one more set of coordinates for what was baked. `displace(layout)`
    gives other positions, the layout with their normals, and the offsets.
    """
    layout = layout_of(mesh)
    if layout is None:
        return None
    layout["slot"] = _slots(mesh, layout, len(materials))
    if displace is not None:
        positions, layout, offsets = displace(layout)
        layout["offsets"] = offsets
    if corner_uv is not None:
        flat = layout["indices"].ravel()
        positions = positions[flat] if displace is not None else None
        layout = _unshared(layout, corner_uv)
    if displace is None:
        positions = positions_of(mesh)[layout["source_vertex"]]
    if not np.isfinite(positions).all():
        raise ValueError(f"the mesh '{name}' has vertices that are not finite")
    attributes = {"POSITION": gltf.accessor(positions, ARRAY_BUFFER, bounds=True)}
    if layout["normals"] is not None:
        attributes["NORMAL"] = gltf.accessor(layout["normals"], ARRAY_BUFFER)
    for k, (_, uv) in enumerate(layout["uvs"]):
        # glTF's v runs down.
        attributes[f"TEXCOORD_{k}"] = gltf.accessor(np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]), ARRAY_BUFFER)
    for k, (_, color) in enumerate(layout["colors"]):
        attributes[f"COLOR_{k}"] = gltf.accessor(color, ARRAY_BUFFER)
    primitives = []
    for slot, indices in _by_slot(layout):
        primitive = {"attributes": attributes, "indices": gltf.accessor(indices.reshape(-1), ELEMENT_ARRAY_BUFFER)}
        if slot < len(materials) and materials[slot] is not None:
            primitive["material"] = materials[slot]
        primitives.append(primitive)
    extension = {"texspace": {"location": list(mesh.texspace_location), "size": list(mesh.texspace_size)}}
    if layout["uvs"]:
        extension["uvNames"] = [n for n, _ in layout["uvs"]]
    if layout["colors"]:
        extension["colorNames"] = [n for n, _ in layout["colors"]]
    record = {"name": name, "primitives": primitives, "extensions": {NAME: extension}}
    return gltf.append("meshes", record), layout


def _slots(mesh, layout, n_slots):
    """Material slot of each triangle."""
    attribute = mesh.attributes.get("material_index")
    if n_slots <= 1 or attribute is None or attribute.domain != "FACE":
        return np.zeros(len(layout["polygon"]), np.int32)
    slot = read_array(attribute.data, "value", np.int32, 1)[layout["polygon"]]
    # Blender shows faces of slots that are not there with the last one.
    return np.clip(slot, 0, n_slots - 1)


def _by_slot(layout):
    """Triangles of each material slot that has any."""
    slot = layout["slot"]
    if not slot.any():
        return [(0, layout["indices"])]
    return [(int(k), layout["indices"][slot == k]) for k in np.unique(slot)]


def write_motion(gltf, mesh_ix, layout, times, steps):
    """Adds vertices and normals at `times` (frames from the frame) to all primitives of a mesh; a step is what `positions_of` and `normals_of` give."""
    source, offsets = layout["source_vertex"], layout.get("offsets", np.float32(0.0))
    motion = {"times": times, "positions": [gltf.accessor(p[source] + offsets, ARRAY_BUFFER, bounds=True) for p, _ in steps]}
    if all(n is not None for _, n in steps) and "offsets" not in layout:
        source = source if layout["domain"] == "POINT" else layout["source_corner"]
        motion["normals"] = [gltf.accessor(n[source], ARRAY_BUFFER) for _, n in steps]
    for primitive in gltf.document["meshes"][mesh_ix]["primitives"]:
        primitive["extensions"] = {NAME: {"motion": motion}}
