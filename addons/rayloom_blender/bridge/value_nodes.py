# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that give values and need more than a table: mixes, ramps, curves, normals, attributes.

Each function takes the graph, the node, the wanted output and the path of groups, and gives an input value of the file, or `None` where it cannot.
"""

from .coordinates import uv_set
from .links import find_source, plain_value, socket_of
from .node_tables import word
from .texture_nodes import TEXTURES
from .values import input_value, link_to

# Places in a table that stands for a curve or a ramp, as many as Cycles takes.
_TABLE = 257


def color_ramp(graph, node, out, path):
    """Color Ramp; one that mixes hues, or bends, as a table."""
    ramp = node.color_ramp
    stops = [[e.position, *e.color] for e in ramp.elements]
    interpolation = word(ramp.interpolation)
    if ramp.color_mode != "RGB" or ramp.interpolation in {"CARDINAL", "B_SPLINE"}:
        interpolation, stops = "linear", [[k / (_TABLE - 1), *ramp.evaluate(k / (_TABLE - 1))] for k in range(_TABLE)]
    record = {"type": "colorRamp", "fac": graph.value(node.inputs[0], path), "interpolation": interpolation, "stops": stops}
    return link_to(graph, record, "alpha" if out.name == "Alpha" else "color")


def curves(graph, node, out, path):
    """RGB Curves, Vector Curves and Float Curve as tables."""
    mapping = node.mapping
    mapping.initialize()
    own = list(mapping.curves)
    x = [p.location[0] for c in own for p in c.points]
    low, high = min(x), max(x)
    if high <= low:
        return None
    at = [low + (high - low) * k / (_TABLE - 1) for k in range(_TABLE)]
    # The fourth curve of RGB Curves comes first.
    first = (lambda v: mapping.evaluate(own[3], v)) if node.type == "CURVE_RGB" else (lambda v: v)
    table = [[mapping.evaluate(c, first(v)) for v in at] for c in own[:3]]
    record = {"type": "curves", "range": [low, high], "table": table, "extrapolate": mapping.extend == "EXTRAPOLATED"}
    if node.type == "CURVE_FLOAT":
        record["isNumber"] = True
    factor, value = (graph.value(s, path) for s in node.inputs[:2])
    return link_to(graph, {**record, "fac": factor, "value": value}, "color")


def map_range(graph, node, out, path):
    """Map Range of numbers and of vectors."""
    is_vector = node.data_type == "FLOAT_VECTOR"
    record = {"type": "mapRange", "clamp": node.clamp, "interpolation": word(node.interpolation_type)}
    if is_vector:
        record["isVector"] = True
    names = {"value": "Vector" if is_vector else "Value", "fromMin": "From Min", "fromMax": "From Max", "toMin": "To Min", "toMax": "To Max"}
    for key, name in {**names, "steps": "Steps"}.items():
        record[key] = input_value(graph, node, name, path)
    return link_to(graph, record)


def clamp(graph, node, out, path):
    """Clamp, both kinds."""
    record = {"type": "clampRange", "kind": word(node.clamp_type)}
    for key, name in (("value", "Value"), ("min", "Min"), ("max", "Max")):
        record[key] = input_value(graph, node, name, path)
    return link_to(graph, record)


def math(graph, node, out, path):
    """Math."""
    record = {"type": "math", "operation": node.operation.lower(), "clamp": node.use_clamp}
    for key, socket in zip("abc", node.inputs):
        if socket.enabled:
            record[key] = graph.value(socket, path)
    return link_to(graph, record)


def vector_math(graph, node, out, path):
    """Vector Math."""
    record = {"type": "vectorMath", "operation": node.operation.lower()}
    for key, socket in zip("abc", [s for s in node.inputs if s.type == "VECTOR"]):
        if socket.enabled:
            record[key] = graph.value(socket, path)
    scale = socket_of(node, "Scale")
    if scale is not None and scale.enabled:
        record["scale"] = graph.value(scale, path)
    return link_to(graph, record, "value" if out.name == "Value" else "color")


def vector_rotate(graph, node, out, path):
    """Vector Rotate."""
    record = {"type": "vectorRotate", "kind": word(node.rotation_type), "invert": node.invert}
    for name in ("Vector", "Center", "Axis", "Angle", "Rotation"):
        record[name.lower()] = input_value(graph, node, name, path)
    return link_to(graph, record, "color")


def mix(graph, node, out, path):
    """Mix of numbers, vectors and colours, and Mix RGB of older files."""
    if node.type == "MIX_RGB":
        factor, a, b = (graph.value(node.inputs[k], path) for k in range(3))
        record = {"clampFactor": True, "clampResult": node.use_clamp}
        blend = node.blend_type
    else:
        sockets = [s for s in node.inputs if s.enabled]
        factor, a, b = (graph.value(s, path) for s in sockets[:3])
        is_color = node.data_type == "RGBA"
        record = {"clampFactor": node.clamp_factor, "clampResult": is_color and node.clamp_result}
        if node.data_type == "FLOAT":
            record["kind"] = "number"
        elif node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM":
            record["kind"] = "parts"
        blend = node.blend_type if is_color else "MIX"
    return link_to(graph, {"type": "mixColor", "blend": blend.lower(), "factor": factor, "a": a, "b": b, **record}, "color")


def separate_color(graph, node, out, path):
    """Separate Color."""
    mode = node.mode.lower()
    index = [s.identifier for s in node.outputs].index(out.identifier)
    record = {"type": "separate", "color": graph.value(node.inputs[0], path)}
    if mode != "rgb":
        record["mode"] = mode
    return link_to(graph, record, "xyz"[index])


def separate_parts(graph, node, out, path):
    """Separate RGB and Separate HSV of older files."""
    index = list(node.outputs).index(next(s for s in node.outputs if s.identifier == out.identifier))
    record = {"type": "separate", "color": graph.value(node.inputs[0], path)}
    if node.type == "SEPHSV":
        record["mode"] = "hsv"
    return link_to(graph, record, "xyz"[index])


def combine_parts(graph, node, out, path):
    """Combine RGB and Combine HSV of older files."""
    x, y, z = (graph.value(s, path) for s in node.inputs[:3])
    record = {"type": "combine", "x": x, "y": y, "z": z}
    if node.type == "COMBHSV":
        record["mode"] = "hsv"
    return link_to(graph, record, "color")


def combine_color(graph, node, out, path):
    """Combine Color."""
    x, y, z = (graph.value(s, path) for s in node.inputs[:3])
    record = {"type": "combine", "x": x, "y": y, "z": z}
    if node.mode != "RGB":
        record["mode"] = node.mode.lower()
    return link_to(graph, record, "color")


def constant(graph, node, out, path):
    """RGB and Value."""
    return plain_value(out)


def normal_map(graph, node, out, path):
    """Normal Map."""
    space = {"TANGENT": "tangent", "OBJECT": "object", "WORLD": "world"}.get(node.space)
    if space is None:
        space = "object" if "OBJECT" in node.space else "world"
        graph.log(f"the normal map '{node.name}' in Blender's old space is taken as in {space} space")
    record = {"type": "normalMap", "color": input_value(graph, node, "Color", path), "strength": input_value(graph, node, "Strength", path)}
    if space != "tangent":
        record["space"] = space
    uv = uv_set(graph, node.uv_map)
    if uv:
        record["uvSet"] = uv
    return link_to(graph, record)


def bump(graph, node, out, path):
    """Bump."""
    record = {"type": "bump", "invert": node.invert}
    for key, name in (("strength", "Strength"), ("distance", "Distance"), ("height", "Height")):
        record[key] = input_value(graph, node, name, path)
    normal = socket_of(node, "Normal")
    if normal is not None and find_source(normal, path)[0] is not None:
        record["normal"] = graph.value(normal, path)
    return link_to(graph, record)


def _color_layer(graph, name):
    graph.names_layers = True
    if not name and graph.color_names:
        return "COLOR_0"
    return f"COLOR_{graph.color_names.index(name)}" if name in graph.color_names else None


def attribute(graph, node, out, path):
    """Color Attribute and Attribute: a colour layer, a UV map, another attribute of the mesh or a property of the object."""
    name = node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name
    layer = _color_layer(graph, name)
    if layer:
        output = {"Alpha": "alpha", "Fac": "fac", "Factor": "fac"}.get(out.name, "color")
        return link_to(graph, {"type": "attribute", "name": layer}, output)
    if name in graph.uv_names:
        return _coordinate_value(graph, "uv", uv_set(graph, name))
    kind = getattr(node, "attribute_type", "GEOMETRY")
    record = {"type": "meshAttribute" if kind == "GEOMETRY" else "objectAttribute", "name": name}
    return link_to(graph, record, {"Alpha": "alpha", "Fac": "fac", "Factor": "fac"}.get(out.name, "color"))


def _coordinate_value(graph, source, uv=0):
    where = {"source": source}
    if uv:
        where["uvSet"] = uv
    return link_to(graph, {"type": "vector", "coordinates": where}, "color")


def texture_coordinate(graph, node, out, path):
    """Texture Coordinate and UV Map where their value is computed with."""
    if node.type == "UVMAP":
        return _coordinate_value(graph, "uv", uv_set(graph, node.uv_map))
    return _coordinate_value(graph, word(out.name.upper()))


def mapping(graph, node, out, path):
    """Mapping where its value is computed with, or its sockets are computed."""
    record = {"type": "mapping", "kind": node.vector_type.lower(), "vector": input_value(graph, node, "Vector", path)}
    for name in ("Location", "Rotation", "Scale"):
        socket = socket_of(node, name)
        if socket is not None and socket.enabled:
            record[name.lower()] = graph.value(socket, path)
    return link_to(graph, record, "color")


SPECIAL = {
    **TEXTURES,
    "VALTORGB": color_ramp,
    "CURVE_RGB": curves,
    "CURVE_VEC": curves,
    "CURVE_FLOAT": curves,
    "MAP_RANGE": map_range,
    "CLAMP": clamp,
    "MATH": math,
    "VECT_MATH": vector_math,
    "VECTOR_ROTATE": vector_rotate,
    "MIX": mix,
    "MIX_RGB": mix,
    "SEPARATE_COLOR": separate_color,
    "COMBINE_COLOR": combine_color,
    "SEPRGB": separate_parts,
    "SEPHSV": separate_parts,
    "COMBRGB": combine_parts,
    "COMBHSV": combine_parts,
    "RGB": constant,
    "VALUE": constant,
    "NORMAL_MAP": normal_map,
    "BUMP": bump,
    "VERTEX_COLOR": attribute,
    "ATTRIBUTE": attribute,
    "TEX_COORD": texture_coordinate,
    "UVMAP": texture_coordinate,
    "MAPPING": mapping,
}
