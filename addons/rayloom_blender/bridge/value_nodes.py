# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that give values and need more than a table: textures, mixes, ramps, normals, attributes.

Each function takes the graph, the node, the wanted output and the path of groups, and gives an input value of the file, or `None` where it cannot.
"""

from .coordinates import uv_set
from .image import pick_image
from .links import find_source, plain_value, socket_of
from .node_tables import word


def _out(graph, record, output=None):
    link = {"node": graph.add(record)}
    if output:
        link["output"] = output
    return link


def _value(graph, node, name, path):
    socket = socket_of(node, name)
    return 0.0 if socket is None else graph.value(socket, path)


def image_texture(graph, node, out, path):
    """Image Texture. A missing picture is pink, as in Cycles."""
    alpha = out.name == "Alpha"
    if node.image is None:
        return 1.0 if alpha else [0.0, 0.0, 0.0]
    image = pick_image(graph.images, node.image, node.image_user, graph.log)
    if image is None:
        return 1.0 if alpha else [1.0, 0.0, 1.0]
    record = {
        "type": "image",
        "image": image,
        "coordinates": graph.coordinates(node, path, "uv"),
        "interpolation": word(node.interpolation),
        "extension": word(node.extension),
    }
    if node.projection != "FLAT":
        record["projection"] = word(node.projection)
        record["blend"] = node.projection_blend
    return _out(graph, record, "alpha" if alpha else "color")


def environment_texture(graph, node, out, path):
    """Environment Texture."""
    if node.image is None:
        return [0.0, 0.0, 0.0]
    image = pick_image(graph.images, node.image, node.image_user, graph.log)
    if image is None:
        return [1.0, 0.0, 1.0]
    record = {
        "type": "environment",
        "image": image,
        "coordinates": graph.coordinates(node, path, "position"),
        "interpolation": word(node.interpolation),
        "projection": word(node.projection),
    }
    return _out(graph, record, "color")


def sky_texture(graph, node, out, path):
    """Sky Texture of every model. Names differ between 4.x and 5.0 (dust became aerosols)."""
    record = {"type": "sky", "model": word(node.sky_type), "coordinates": graph.coordinates(node, path, "position")}
    if node.sky_type in {"PREETHAM", "HOSEK_WILKIE"}:
        record["sunDirection"] = list(node.sun_direction)
        record["turbidity"] = node.turbidity
        record["groundAlbedo"] = node.ground_albedo
    else:
        record.update(
            sunDisc=node.sun_disc,
            sunSize=node.sun_size,
            sunIntensity=node.sun_intensity,
            sunElevation=node.sun_elevation,
            sunRotation=node.sun_rotation,
            altitude=node.altitude,
            airDensity=node.air_density,
            dustDensity=getattr(node, "aerosol_density", getattr(node, "dust_density", 1.0)),
            ozoneDensity=node.ozone_density,
        )
    return _out(graph, record, "color")


def checker_texture(graph, node, out, path):
    """Checker Texture."""
    record = {"type": "checker", "coordinates": graph.coordinates(node, path, "generated")}
    record["scale"] = _value(graph, node, "Scale", path)
    record["color1"] = _value(graph, node, "Color1", path)
    record["color2"] = _value(graph, node, "Color2", path)
    return _out(graph, record, "fac" if out.name in {"Fac", "Factor"} else "color")


def noise_texture(graph, node, out, path):
    """Noise Texture (from 4.1 on it has Musgrave's kinds too)."""
    record = {
        "type": "noise",
        "coordinates": graph.coordinates(node, path, "generated"),
        "kind": word(getattr(node, "noise_type", "FBM")),
        "normalize": bool(getattr(node, "normalize", True)),
        "dimensions": int(node.noise_dimensions[0]),
    }
    for name in ("W", "Scale", "Detail", "Roughness", "Lacunarity", "Offset", "Gain", "Distortion"):
        socket = socket_of(node, name)
        if socket is not None:
            record[name.lower()] = graph.value(socket, path)
    return _out(graph, record, "fac" if out.name in {"Fac", "Factor"} else "color")


def gradient_texture(graph, node, out, path):
    """Gradient Texture."""
    kind = word(node.gradient_type)
    record = {"type": "gradient", "coordinates": graph.coordinates(node, path, "generated"), "kind": kind}
    return _out(graph, record, "fac" if out.name in {"Fac", "Factor"} else "color")


def color_ramp(graph, node, out, path):
    """Color Ramp."""
    ramp = node.color_ramp
    stops = [[e.position, *e.color] for e in ramp.elements]
    record = {"type": "colorRamp", "fac": graph.value(node.inputs[0], path), "interpolation": word(ramp.interpolation), "stops": stops}
    if ramp.color_mode != "RGB" or ramp.interpolation in {"CARDINAL", "B_SPLINE"}:
        graph.log(f"the ramp '{node.name}' is taken as a linear one in RGB")
        record["interpolation"] = "linear"
    return _out(graph, record, "alpha" if out.name == "Alpha" else "color")


def map_range(graph, node, out, path):
    """Map Range of numbers."""
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        return None
    record = {"type": "mapRange", "clamp": node.clamp}
    for key, name in (("value", "Value"), ("fromMin", "From Min"), ("fromMax", "From Max"), ("toMin", "To Min"), ("toMax", "To Max")):
        record[key] = _value(graph, node, name, path)
    return _out(graph, record)


def clamp(graph, node, out, path):
    """Clamp, both kinds."""
    low, high = _value(graph, node, "Min", path), _value(graph, node, "Max", path)
    return _out(graph, {"type": "clampRange", "value": _value(graph, node, "Value", path), "min": low, "max": high})


def math(graph, node, out, path):
    """Math."""
    record = {"type": "math", "operation": node.operation.lower(), "clamp": node.use_clamp}
    for key, socket in zip("abc", node.inputs):
        if socket.enabled:
            record[key] = graph.value(socket, path)
    return _out(graph, record)


def vector_math(graph, node, out, path):
    """Vector Math."""
    record = {"type": "vectorMath", "operation": node.operation.lower()}
    for key, socket in zip("abc", [s for s in node.inputs if s.type == "VECTOR"]):
        if socket.enabled:
            record[key] = graph.value(socket, path)
    scale = socket_of(node, "Scale")
    if scale is not None and scale.enabled:
        record["scale"] = graph.value(scale, path)
    return _out(graph, record, "value" if out.name == "Value" else "color")


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
        blend = node.blend_type if is_color else "MIX"
    return _out(graph, {"type": "mixColor", "blend": blend.lower(), "factor": factor, "a": a, "b": b, **record}, "color")


def separate_color(graph, node, out, path):
    """Separate Color."""
    mode = node.mode.lower()
    index = [s.identifier for s in node.outputs].index(out.identifier)
    record = {"type": "separate", "color": graph.value(node.inputs[0], path)}
    if mode != "rgb":
        record["mode"] = mode
    return _out(graph, record, "xyz"[index])


def combine_color(graph, node, out, path):
    """Combine Color."""
    x, y, z = (graph.value(s, path) for s in node.inputs[:3])
    record = {"type": "combine", "x": x, "y": y, "z": z}
    if node.mode != "RGB":
        record["mode"] = node.mode.lower()
    return _out(graph, record, "color")


def constant(graph, node, out, path):
    """RGB and Value."""
    return plain_value(out)


def normal_map(graph, node, out, path):
    """Normal Map."""
    space = {"TANGENT": "tangent", "OBJECT": "object", "WORLD": "world"}.get(node.space)
    if space is None:
        space = "object" if "OBJECT" in node.space else "world"
        graph.log(f"the normal map '{node.name}' in Blender's old space is taken as in {space} space")
    record = {"type": "normalMap", "color": _value(graph, node, "Color", path), "strength": _value(graph, node, "Strength", path)}
    if space != "tangent":
        record["space"] = space
    uv = uv_set(graph, node.uv_map)
    if uv:
        record["uvSet"] = uv
    return _out(graph, record)


def bump(graph, node, out, path):
    """Bump."""
    record = {"type": "bump", "invert": node.invert}
    for key, name in (("strength", "Strength"), ("distance", "Distance"), ("height", "Height")):
        record[key] = _value(graph, node, name, path)
    normal = socket_of(node, "Normal")
    if normal is not None and find_source(normal, path)[0] is not None:
        record["normal"] = graph.value(normal, path)
    return _out(graph, record)


def _color_layer(graph, name):
    graph.names_layers = True
    if not name and graph.color_names:
        return "COLOR_0"
    return f"COLOR_{graph.color_names.index(name)}" if name in graph.color_names else None


def attribute(graph, node, out, path):
    """Color Attribute, and Attribute where it names a colour layer or a UV map."""
    name = node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name
    layer = _color_layer(graph, name)
    if layer:
        output = {"Alpha": "alpha", "Fac": "fac"}.get(out.name, "color")
        return _out(graph, {"type": "attribute", "name": layer}, output)
    if name in graph.uv_names:
        return _coordinate_value(graph, "uv", uv_set(graph, name))
    return None


def _coordinate_value(graph, source, uv=0):
    where = {"source": source}
    if uv:
        where["uvSet"] = uv
    return _out(graph, {"type": "vector", "coordinates": where}, "color")


def texture_coordinate(graph, node, out, path):
    """Texture Coordinate and UV Map where their value is computed with."""
    if node.type == "UVMAP":
        return _coordinate_value(graph, "uv", uv_set(graph, node.uv_map))
    return _coordinate_value(graph, word(out.name.upper()))


def mapping(graph, node, out, path):
    """Mapping where its value is computed with, or its sockets are computed."""
    record = {"type": "mapping", "kind": node.vector_type.lower(), "vector": _value(graph, node, "Vector", path)}
    for name in ("Location", "Rotation", "Scale"):
        socket = socket_of(node, name)
        if socket is not None and socket.enabled:
            record[name.lower()] = graph.value(socket, path)
    return _out(graph, record, "color")


SPECIAL = {
    "TEX_IMAGE": image_texture,
    "TEX_ENVIRONMENT": environment_texture,
    "TEX_SKY": sky_texture,
    "TEX_CHECKER": checker_texture,
    "TEX_NOISE": noise_texture,
    "TEX_GRADIENT": gradient_texture,
    "VALTORGB": color_ramp,
    "MAP_RANGE": map_range,
    "CLAMP": clamp,
    "MATH": math,
    "VECT_MATH": vector_math,
    "MIX": mix,
    "MIX_RGB": mix,
    "SEPARATE_COLOR": separate_color,
    "COMBINE_COLOR": combine_color,
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
