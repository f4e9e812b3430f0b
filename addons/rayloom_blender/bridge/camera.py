# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras: glTF's own record, and Blender's whole one in the extension."""

import math

from ..core.schema import NAME

_PANORAMA = {
    "EQUIRECTANGULAR": "equirectangular",
    "EQUIANGULAR_CUBEMAP_FACE": "equiangularCubemap",
    "MIRRORBALL": "mirrorBall",
    "FISHEYE_EQUIDISTANT": "fisheyeEquidistant",
    "FISHEYE_EQUISOLID": "fisheyeEquisolid",
    "FISHEYE_LENS_POLYNOMIAL": "fisheyePolynomial",
    "CENTRAL_CYLINDRICAL": "centralCylindrical",
}


def _setting(camera, key, default):
    """A panorama setting: at the camera in 5.0, in Cycles' own group before."""
    if hasattr(camera, key):
        return getattr(camera, key)
    return getattr(getattr(camera, "cycles", None), key, default)


def _panorama(camera):
    kind = _setting(camera, "panorama_type", "EQUIRECTANGULAR")
    out = {"type": _PANORAMA.get(kind, "equirectangular")}
    if kind == "EQUIRECTANGULAR":
        out["latitude"] = [_setting(camera, "latitude_min", -math.pi / 2), _setting(camera, "latitude_max", math.pi / 2)]
        out["longitude"] = [_setting(camera, "longitude_min", -math.pi), _setting(camera, "longitude_max", math.pi)]
    elif kind == "FISHEYE_LENS_POLYNOMIAL":
        out["polynomial"] = [_setting(camera, f"fisheye_polynomial_k{k}", 0.0) for k in range(5)]
        out["fisheyeFov"] = _setting(camera, "fisheye_fov", math.pi)
    elif kind == "CENTRAL_CYLINDRICAL":
        out["cylinder"] = {
            "longitude": [_setting(camera, f"central_cylindrical_range_u_{end}", v) for end, v in (("min", -math.pi), ("max", math.pi))],
            "height": [_setting(camera, f"central_cylindrical_range_v_{end}", v) for end, v in (("min", -1.0), ("max", 1.0))],
            "radius": _setting(camera, "central_cylindrical_radius", 1.0),
        }
    elif kind.startswith("FISHEYE"):
        out["fisheyeFov"] = _setting(camera, "fisheye_fov", math.pi)
        out["fisheyeLens"] = _setting(camera, "fisheye_lens", 10.5)
    return out


def _focus(camera, world):
    """Distance of the plane in focus along the camera's axis."""
    target = camera.dof.focus_object
    if target is None:
        return camera.dof.focus_distance
    place = target.matrix_world.translation
    axis = world.to_3x3().col[2].normalized()
    return abs((world.translation - place).dot(axis))


def camera_record(camera, world, render, scale=1.0):
    """A record of glTF's camera table with the extension. `world`: the camera's matrix, `render`: the scene's render settings."""
    width = render.resolution_x * scale * render.pixel_aspect_x
    height = render.resolution_y * scale * render.pixel_aspect_y
    aspect = width / height
    extension = {
        "type": {"PERSP": "perspective", "ORTHO": "orthographic", "PANO": "panorama"}.get(camera.type, "perspective"),
        "lens": camera.lens,
        "sensorWidth": camera.sensor_width,
        "sensorHeight": camera.sensor_height,
        "sensorFit": camera.sensor_fit.lower(),
        "clip": [camera.clip_start, camera.clip_end],
    }
    if camera.shift_x or camera.shift_y:
        extension["shift"] = [camera.shift_x, camera.shift_y]
    if camera.type == "ORTHO":
        extension["orthoScale"] = camera.ortho_scale
    if camera.type == "PANO":
        extension["panorama"] = _panorama(camera)
    if camera.dof.use_dof:
        d = camera.dof
        extension["dof"] = {
            "focusDistance": _focus(camera, world),
            "fStop": d.aperture_fstop,
            "blades": d.aperture_blades,
            "rotation": d.aperture_rotation,
            "ratio": d.aperture_ratio,
        }
    horizontal = camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and width >= height)
    record = {"name": camera.name, "extensions": {NAME: extension}}
    if camera.type == "ORTHO":
        half = camera.ortho_scale / 2.0
        record["type"] = "orthographic"
        x, y = (half, half / aspect) if horizontal else (half * aspect, half)
        record["orthographic"] = {"xmag": x, "ymag": y, "znear": max(camera.clip_start, 0.0), "zfar": camera.clip_end}
    else:
        sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
        half = sensor / (2.0 * camera.lens) if camera.type == "PERSP" else 1.0
        yfov = 2.0 * math.atan(half / aspect if horizontal else half)
        record["type"] = "perspective"
        record["perspective"] = {"aspectRatio": aspect, "yfov": yfov, "znear": max(camera.clip_start, 1e-6), "zfar": camera.clip_end}
    return record
