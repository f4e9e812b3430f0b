# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture nodes → records of the file. Functions as in value_nodes.py."""

import bpy

from .image import pick_image
from .links import find_source, plain_value, socket_of
from .node_tables import word
from .values import fac_or_color, input_value, link_to


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
    return link_to(graph, record, "alpha" if alpha else "color")


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
    return link_to(graph, record, "color")


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
    return link_to(graph, record, "color")


def checker_texture(graph, node, out, path):
    """Checker Texture."""
    record = {"type": "checker", "coordinates": graph.coordinates(node, path, "generated")}
    record["scale"] = input_value(graph, node, "Scale", path)
    record["color1"] = input_value(graph, node, "Color1", path)
    record["color2"] = input_value(graph, node, "Color2", path)
    return link_to(graph, record, fac_or_color(out))


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
    return link_to(graph, record, fac_or_color(out))


def gradient_texture(graph, node, out, path):
    """Gradient Texture."""
    kind = word(node.gradient_type)
    record = {"type": "gradient", "coordinates": graph.coordinates(node, path, "generated"), "kind": kind}
    return link_to(graph, record, fac_or_color(out))


def _sockets(graph, node, path, names):
    """Inputs by their keys in the file, of the sockets that the node has."""
    return {key: graph.value(socket, path) for key, name in names.items() if (socket := socket_of(node, name)) is not None}


def voronoi_texture(graph, node, out, path):
    """Voronoi Texture."""
    record = {
        "type": "voronoi",
        "coordinates": graph.coordinates(node, path, "generated"),
        "feature": {"SMOOTH_F1": "smoothF1", "N_SPHERE_RADIUS": "nSphereRadius"}.get(node.feature) or word(node.feature),
        "metric": word(node.distance),
        "dimensions": int(node.voronoi_dimensions[0]),
        "normalize": bool(getattr(node, "normalize", False)),
        # Cells are others from 5.0 on (measured).
        "hash": "pcg" if bpy.app.version >= (5, 0, 0) else "jenkins",
    }
    names = ("W", "Scale", "Detail", "Roughness", "Lacunarity", "Smoothness", "Exponent", "Randomness")
    record.update(_sockets(graph, node, path, {name.lower(): name for name in names}))
    return link_to(graph, record, out.name.lower())


def white_noise_texture(graph, node, out, path):
    """White Noise Texture."""
    record = {"type": "whiteNoise", "dimensions": int(node.noise_dimensions[0])}
    if record["dimensions"] > 1:
        # Without a link its vector is the socket's own.
        x, y, z = plain_value(socket_of(node, "Vector"))
        fixed = link_to(graph, {"type": "combine", "x": x, "y": y, "z": z})
        record["coordinates"] = graph.coordinates(node, path, "generated") if find_source(socket_of(node, "Vector"), path)[0] else fixed
    record.update(_sockets(graph, node, path, {"w": "W"}))
    return link_to(graph, record, fac_or_color(out))


def wave_texture(graph, node, out, path):
    """Wave Texture."""
    bands = node.wave_type == "BANDS"
    record = {
        "type": "wave",
        "coordinates": graph.coordinates(node, path, "generated"),
        "kind": word(node.wave_type),
        "direction": word(node.bands_direction if bands else node.rings_direction),
        "profile": word(node.wave_profile),
    }
    names = {"scale": "Scale", "distortion": "Distortion", "detail": "Detail", "detailScale": "Detail Scale"}
    names.update(detailRoughness="Detail Roughness", phaseOffset="Phase Offset")
    record.update(_sockets(graph, node, path, names))
    return link_to(graph, record, fac_or_color(out))


def magic_texture(graph, node, out, path):
    """Magic Texture."""
    record = {"type": "magic", "coordinates": graph.coordinates(node, path, "generated"), "depth": node.turbulence_depth}
    record.update(_sockets(graph, node, path, {"scale": "Scale", "distortion": "Distortion"}))
    return link_to(graph, record, fac_or_color(out))


def brick_texture(graph, node, out, path):
    """Brick Texture."""
    record = {
        "type": "brick",
        "coordinates": graph.coordinates(node, path, "generated"),
        "offset": node.offset,
        "offsetFrequency": node.offset_frequency,
        "squash": node.squash,
        "squashFrequency": node.squash_frequency,
    }
    names = {"color1": "Color1", "color2": "Color2", "mortar": "Mortar", "scale": "Scale", "mortarSize": "Mortar Size"}
    names.update(mortarSmooth="Mortar Smooth", bias="Bias", brickWidth="Brick Width", rowHeight="Row Height")
    record.update(_sockets(graph, node, path, names))
    return link_to(graph, record, fac_or_color(out))


TEXTURES = {
    "TEX_BRICK": brick_texture,
    "TEX_CHECKER": checker_texture,
    "TEX_ENVIRONMENT": environment_texture,
    "TEX_GRADIENT": gradient_texture,
    "TEX_IMAGE": image_texture,
    "TEX_MAGIC": magic_texture,
    "TEX_NOISE": noise_texture,
    "TEX_SKY": sky_texture,
    "TEX_VORONOI": voronoi_texture,
    "TEX_WAVE": wave_texture,
    "TEX_WHITE_NOISE": white_noise_texture,
}
