"""Cameras, film and shutter."""

import math

import bpy
from mathutils import Vector

from .lamps import matt
from .stage import ball, box, camera, case, closure, degrees, floor, lamp, look_at


def rows():
    """Balls and boxes near and far, two small lamps, no camera."""
    floor(half=12.0)
    lamp("SUN", (2, -3, 5), (0, 0, 0), 2.5, angle=degrees(3))
    for k in range(4):
        ball(matt(f"Ball{k}", 0.2 + 0.2 * k, 0.5, 0.8 - 0.2 * k), place=(-1.6 + 0.5 * k, -2.0 + 2.2 * k, 0.5), radius=0.5, segments=16, name=f"Ball{k}")
        box(matt(f"Box{k}", 0.8, 0.3 + 0.15 * k, 0.2), place=(0.7 + 0.4 * k, -1.4 + 2.2 * k, 0.45), size=(0.7, 0.7, 0.9), turn=0.4 * k, name=f"Box{k}")
    for k in range(3):
        shine = closure(f"Spark{k}", "ShaderNodeEmission", Color=(1.0, 0.6, 0.3), Strength=40.0)
        ball(shine, place=(-2.5 + 2.5 * k, 5.0, 2.2), radius=0.06, segments=12, name=f"Spark{k}")


def seen(name, about, size=(72, 54), spp=16, place=(0, -7, 2.2), target=(0, 0, 0.7), **settings):
    """A case of one camera."""

    def build():
        rows()
        o = camera(place, target)
        for key, value in settings.items():
            owner = o.data
            *parts, last = key.split("__")
            for part in parts:
                owner = getattr(owner, part)
            setattr(owner, last, value)

    case("camera/" + name, about, size, spp)(build)


seen("perspective", "A perspective camera.", lens=40.0)
seen("upright", "A picture higher than wide: the sensor fits its longer side.", size=(48, 72), lens=35.0)
seen("fit_vertical", "The sensor's height fits.", lens=35.0, sensor_fit="VERTICAL", sensor_height=20.0)
seen("fit_horizontal", "The sensor's width fits a high picture.", size=(48, 72), lens=35.0, sensor_fit="HORIZONTAL", sensor_width=30.0)
seen("shift", "A lens moved aside.", lens=35.0, shift_x=0.25, shift_y=-0.15)
FAR = {"place": (0, -14, 3.7)}  # its near plane does not cut the ground
seen("orthographic", "An orthographic camera.", **FAR, type="ORTHO", ortho_scale=6.0)
seen("orthographic_shift", "An orthographic camera, moved aside, on a high picture.", size=(48, 64), **FAR, type="ORTHO", ortho_scale=7.0, shift_x=0.2, shift_y=0.1)
seen("orthographic_focus", "Depth of field without perspective.", spp=32, **FAR, type="ORTHO", ortho_scale=6.0, dof__use_dof=True, dof__focus_distance=14.0, dof__aperture_fstop=1.0)
FOCUS = {"dof__use_dof": True, "dof__focus_distance": 5.5, "dof__aperture_fstop": 0.1, "lens": 45.0}
seen("focus", "Depth of field.", spp=32, **FOCUS)
seen("focus_blades", "Depth of field through five blades, turned.", spp=32, **FOCUS, dof__aperture_blades=5, dof__aperture_rotation=0.3)
seen("focus_ratio", "Depth of field through an anamorphic lens.", spp=32, **FOCUS, dof__aperture_ratio=2.0)


def panorama(name, about, kind, size=(72, 54), **settings):
    """A case of a panoramic camera among the things; its settings are Cycles' own up to 4.5, the camera's since 5.0."""

    def build():
        rows()
        data = camera((0, -0.6, 1.2), (0, 5, 1.0), type="PANO").data
        owner = data if hasattr(data, "panorama_type") else data.cycles
        for key, value in {"panorama_type": kind, **settings}.items():
            setattr(owner, key, value)

    case("camera/" + name, about, size)(build)


panorama("equirectangular", "All directions.", "EQUIRECTANGULAR", (96, 48))
panorama("equirectangular_part", "A part of all directions.", "EQUIRECTANGULAR", latitude_min=-0.6, latitude_max=0.7, longitude_min=-1.0, longitude_max=1.0)
panorama("equirectangular_aside", "A part of all directions that is not in the middle.", "EQUIRECTANGULAR", longitude_min=-0.4, longitude_max=1.8)
panorama("fisheye_equidistant", "A fisheye with equal distances.", "FISHEYE_EQUIDISTANT", (60, 60), fisheye_fov=math.pi)
panorama("fisheye_equisolid", "A fisheye with equal areas.", "FISHEYE_EQUISOLID", fisheye_fov=math.pi, fisheye_lens=10.5)
panorama("fisheye_polynomial", "A fisheye after a polynomial.", "FISHEYE_LENS_POLYNOMIAL", fisheye_fov=math.pi)
panorama("mirror_ball", "A mirror ball.", "MIRRORBALL", (60, 60))
panorama("cylinder", "A cylinder around the camera.", "CENTRAL_CYLINDRICAL")


def _moving(o, prop, before, after):
    """A straight movement from the frame before to the one after."""
    for frame, value in ((0, before), (2, after)):
        setattr(o, prop, value)
        o.keyframe_insert(prop, frame=frame)
    for curve in o.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def _blur(shutter=1.0):
    scene = bpy.context.scene
    scene.frame_set(1)
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = shutter


@case("motion/moving", "A ball that moves while the shutter is open.", spp=32)
def moving():
    rows()
    camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    _moving(bpy.data.objects["Ball0"], "location", Vector((-2.6, -2, 0.5)), Vector((-0.6, -2, 0.9)))
    _blur()


@case("motion/turning", "A box that turns.", spp=32)
def turning():
    rows()
    camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    _moving(bpy.data.objects["Box0"], "rotation_euler", (0, 0, -0.7), (0, 0, 0.9))
    _blur(0.8)


@case("motion/camera", "A camera that moves.", spp=32)
def camera_moves():
    rows()
    o = camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    _moving(o, "location", Vector((-0.5, -7, 2.2)), Vector((0.5, -7, 2.0)))
    _blur(0.5)


@case("motion/bending", "A mesh whose vertices move.", spp=32)
def bending():
    rows()
    camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    o = bpy.data.objects["Ball0"]
    o.shape_key_add(name="Basis")
    key = o.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 2.2
    for frame, value in ((0, 0.0), (2, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    for curve in o.data.shape_keys.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    _blur()


@case("film/box", "A pixel filter of the shape of a box.")
def filter_box():
    rows()
    camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    bpy.context.scene.cycles.pixel_filter_type = "BOX"


@case("film/gaussian", "A wide filter in the shape of a bell.")
def filter_gaussian():
    rows()
    camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    c = bpy.context.scene.cycles
    c.pixel_filter_type, c.filter_width = "GAUSSIAN", 3.0


@case("film/exposure", "Exposure of the film.")
def exposure():
    rows()
    camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    bpy.context.scene.cycles.film_exposure = 2.5


@case("film/pixel_aspect", "Pixels that are not square.")
def pixel_aspect():
    rows()
    o = camera((0, -7, 2.2), (0, 0, 0.7), 40.0)
    look_at(o, (0.3, 0, 0.6))
    bpy.context.scene.render.pixel_aspect_x = 1.5
