"""Depth images of a plane and boxes by exact intersection, with known truth."""

import math

import numpy as np

from autonomy.perception import DepthImage, camera_pose

WIDTH, HEIGHT = 320, 240
VERTICAL_FOV_RAD = math.radians(60.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)
DOWN = math.pi / 2


def quat_of(rotation_vector):
    angle = float(np.linalg.norm(rotation_vector))
    axis = np.array(rotation_vector) / (angle or 1.0)
    return (math.cos(angle / 2), *(math.sin(angle / 2) * axis).tolist())


def box(center, size):
    """Upright box as its lower and upper corner."""
    return np.array(center) - np.array(size) / 2, np.array(center) + np.array(size) / 2


def look_down(
    eye=(0.0, 0.0, 4.0),
    quat=LEVEL,
    *,
    ground=0.0,
    gradient=(0.0, 0.0),
    boxes=(),
    believed=None,
    shape=(HEIGHT, WIDTH),
    pitch_down=DOWN,
):
    """View of a camera at `eye` of the plane z = ground + gradient . (x, y) and of boxes.

    `believed` is the pose (position, quaternion) that the vehicle estimates, by default the true
    one. A `pitch_down` smaller than straight down looks ahead, east.
    """
    focal = shape[0] / 2 / math.tan(VERTICAL_FOV_RAD / 2)
    cx, cy = (shape[1] - 1) / 2, (shape[0] - 1) / 2
    _, rotation = camera_pose(eye, quat, (0.0, 0.0, 0.0), pitch_down)
    v, u = np.mgrid[: shape[0], : shape[1]]
    rays = np.stack([(u - cx) / focal, (v - cy) / focal, np.ones(shape)], axis=-1) @ rotation.T
    depth = _to_plane(np.array(eye), rays, ground, gradient)
    for low, high in boxes:
        depth = np.minimum(depth, _to_box(np.array(eye), rays, low, high))
    position, rotation = camera_pose(*(believed or (eye, quat)), (0.0, 0.0, 0.0), pitch_down)
    return DepthImage(
        depth_m=depth.astype(np.float32),
        fx=focal,
        fy=focal,
        cx=cx,
        cy=cy,
        position_enu_m=position,
        rotation_enu_from_optical=rotation,
    )


def _to_plane(eye, rays, ground, gradient):
    normal = np.array([-gradient[0], -gradient[1], 1.0])
    fall = rays @ normal
    with np.errstate(divide="ignore"):
        depth = (ground - eye @ normal) / fall
    return np.where(depth > 0, depth, np.inf)


def _to_box(eye, rays, low, high):
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (low - eye) / rays, (high - eye) / rays
    enter = np.nanmax(np.minimum(one, other), axis=-1)
    leave = np.nanmin(np.maximum(one, other), axis=-1)
    return np.where((enter <= leave) & (enter > 0), enter, np.inf)
