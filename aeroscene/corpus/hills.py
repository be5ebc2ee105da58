"""The scene `hills`: slopes, terraces and a hollow with houses and trees; always the same."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import count

import numpy as np
from jaxtyping import Float

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.corpus.field import HILLS_NAME
from aeroscene.scene import OrientedBox, Relief, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import by_name
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

_HALF_M, _SPACING_M = 60.0, 2.0
_FLOOR_M, _CEILING_M = -6.0, 50.0
_START, _TARGET = (-38.0, -30.0), (34.0, 30.0)
_PAD_M, _PAD_RISE_M = 2.6, 0.06
_HOUSES = (((4.0, -24.0), 0.4, (9.0, 12.0, 5.6)), ((-26.0, 20.0), -0.5, (8.0, 10.0, 4.8)))
"""Place, heading and size of each house."""
_LEVEL = ((_START, 4.0), (_TARGET, 8.0), *((place, 9.0) for place, _, _ in _HOUSES))
"""Middle and radius of each piece of level ground."""
_BANK_M = 9.0
"""Width of the bank around level ground."""
_N_TREES = 40
_TREE_M = (3.0, 3.0, 7.0)
_APART_M = 14.0
"""Distance of trees from the middle of level ground."""


def hills_scene() -> Scene:
    """A hillside to start on and a knoll to land on, without any pavement."""
    relief = _relief()
    objects = _objects(relief)
    x, y = _START
    scene = Scene(
        scene_id=HILLS_NAME,
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-_HALF_M, -_HALF_M, _FLOOR_M),
        extent_max_enu_m=(_HALF_M, _HALF_M, _CEILING_M),
        start_position_enu_m=(x, y, round(float(relief.height_m(x, y)) + _PAD_RISE_M, 4)),
        start_yaw_rad=0.7,
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=objects,
        theme="hillside",
        relief=relief,
    )
    return replace(scene, interaction_areas=derive_interaction_areas(scene))


def _relief() -> Relief:
    """A slope to the north-east with a knoll, a hollow and ripples, level below pads and houses."""
    line = np.arange(-_HALF_M, _HALF_M + _SPACING_M / 2, _SPACING_M)
    x, y = line[None, :], line[:, None]
    heights = _open_land_m(x, y)
    for (east, north), radius_m in _LEVEL:
        share = np.clip((np.hypot(x - east, y - north) - radius_m) / _BANK_M, 0.0, 1.0)
        # A smooth step: without it the bank would have edges at its top and foot.
        share = share**2 * (3.0 - 2.0 * share)
        level_m = float(_open_land_m(np.array(east), np.array(north)))
        heights = level_m + share * (heights - level_m)
    return Relief((-_HALF_M, -_HALF_M), _SPACING_M, np.round(heights, 3))


def _open_land_m(x: np.ndarray, y: np.ndarray) -> Float[np.ndarray, "*n"]:
    slope = 0.04 * x + 0.03 * y + 3.0
    knoll = 5.0 * np.exp(-((x - 34.0) ** 2 + (y - 30.0) ** 2) / 26.0**2)
    hollow = 7.0 * np.exp(-((x - 28.0) ** 2 + (y + 34.0) ** 2) / 20.0**2)
    ripples = 0.6 * np.sin(x / 9.0) * np.cos(y / 7.0)
    return slope + knoll - hollow + ripples


def _objects(relief: Relief) -> tuple[SceneObject, ...]:
    numbers = count()
    pad_m = (_PAD_M, _PAD_M, _PAD_RISE_M)
    return (
        _standing(next(numbers), "landing_pad", relief, _START, 0.0, pad_m, is_start=True),
        _standing(next(numbers), "landing_pad", relief, _TARGET, 0.3, pad_m),
        *(_standing(next(numbers), "house", relief, *house) for house in _HOUSES),
        *(_standing(next(numbers), "tree", relief, *tree) for tree in _trees()),
    )


def _trees() -> list[tuple[tuple[float, float], float, tuple[float, float, float]]]:
    """Place, heading and size of each tree, away from level ground."""
    rng, found = np.random.default_rng(7), []
    while len(found) < _N_TREES:
        x, y = rng.uniform(4.0 - _HALF_M, _HALF_M - 4.0, 2).round(2).tolist()
        yaw, factor = rng.uniform(0.0, math.tau), rng.uniform(0.7, 1.3)
        away_m = min(math.dist((x, y), place) for place, _ in _LEVEL)
        near_m = min((math.dist((x, y), place) for place, _, _ in found), default=math.inf)
        if away_m > _APART_M and near_m > 1.6 * _TREE_M[0]:
            length, width, rise = (round(factor * side, 2) for side in _TREE_M)
            found.append(((x, y), round(yaw, 3), (length, width, rise)))
    return found


def _standing(
    number: int,
    category: str,
    relief: Relief,
    place: tuple[float, float],
    yaw_rad: float,
    size_m: tuple[float, float, float],
    **attributes: bool,
) -> SceneObject:
    """An upright object on the lowest ground below it."""
    box = OrientedBox(p=(*place, 0.0), q=quat_from_yaw(yaw_rad), s=size_m)
    corners = np.vstack([box.corners()[:, :2], place])
    # Houses are sunk to the lowest ground below them, so that no corner hangs in the air.
    foot_m = float(relief.height_m(*corners.T).min())
    # A trunk is thin: the ground at its middle counts.
    if category == "tree":
        foot_m = float(relief.height_m(*place)) - 0.1
    z = round(foot_m + size_m[2] / 2, 4)
    return SceneObject(
        id=number,
        scene_id=HILLS_NAME,
        parent_id=None,
        category_id=by_name()[category].id,
        bbox=OrientedBox(p=(*place, z), q=box.q, s=size_m),
        domain="outdoor",
        attributes=attributes,
    )
