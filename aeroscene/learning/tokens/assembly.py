"""Assembly of a scene document from a skeleton and its geometry."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aeroscene.corpus.curation.curate import HEADROOM_M
from aeroscene.learning.tokens.geometry import Geometry
from aeroscene.learning.tokens.kinds import OPENINGS, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton
from aeroscene.scene import AttributeValue, OrientedBox, Scene, SceneObject
from aeroscene.scene.box import MIN_SIZE_M, quat_from_yaw
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

_OPEN_SKY_M = 22.0
"""Least height of the flight volume under open sky."""


def assemble(
    skeleton: Skeleton,
    geometry: Geometry,
    vocabulary: Vocabulary,
    *,
    scene_id: str,
    seed: int,
    rng: np.random.Generator,
) -> Scene:
    """The scene that a skeleton and its geometry are, without interaction areas.

    `rng` draws the looks.

    Raises:
        SceneError: If a number is not finite.
    """
    low, high = _extent(skeleton, geometry)
    looks = _draw_looks(skeleton, vocabulary, rng)
    objects: list[SceneObject] = []
    for i in range(1, len(skeleton)):
        parent_id = int(skeleton.parent[i]) - 1 if skeleton.parent[i] else None
        made = _made(skeleton, geometry, vocabulary, i, looks[i])
        objects.append(replace(made, id=i - 1, scene_id=scene_id, parent_id=parent_id))
    pad = next((o for o in objects if o.attributes.get("is_start")), None)
    start = (0.0, 0.0, 0.0) if pad is None else _top_middle(pad)
    return Scene(
        scene_id=scene_id,
        domain=skeleton.domain,
        seed=seed,
        extent_min_enu_m=low,
        extent_max_enu_m=high,
        start_position_enu_m=tuple(np.clip(start, low, high).tolist()),
        start_yaw_rad=round(math.atan2(-start[1], -start[0]), 6),
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=tuple(objects),
    )


def _made(
    skeleton: Skeleton,
    geometry: Geometry,
    vocabulary: Vocabulary,
    i: int,
    looks: dict[str, AttributeValue],
) -> SceneObject:
    """The object of a token, as yet without a number, a scene and a parent."""
    kind = vocabulary.kinds[skeleton.kind_id[i]]
    return SceneObject(
        id=0,
        scene_id="",
        parent_id=None,
        category_id=int(vocabulary.category_id[skeleton.kind_id[i]]),
        bbox=_box(geometry, i),
        domain=kind.domain,
        attributes=looks | dict(kind.attributes) | _openings(geometry, i, kind.openings),
    )


def _box(geometry: Geometry, i: int) -> OrientedBox:
    size = np.maximum(np.round(geometry.size_m[i], 3), MIN_SIZE_M)
    return OrientedBox(
        tuple(np.round(geometry.center_enu_m[i], 4).tolist()),
        quat_from_yaw(float(geometry.yaw_rad[i])),
        tuple(size.tolist()),
    )


def _openings(geometry: Geometry, i: int, names: tuple[str, ...]) -> dict[str, AttributeValue]:
    return {name: round(float(geometry.openings_m[i, OPENINGS.index(name)]), 4) for name in names}


def _top_middle(pad: SceneObject) -> tuple[float, float, float]:
    x, y, z = pad.bbox.p
    return (x, y, round(z + pad.bbox.s[2] / 2, 4))


def _extent(
    skeleton: Skeleton, geometry: Geometry
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """The site's outline; up to the roof indoors, some way above everything outdoors."""
    half_x, half_y = np.round(geometry.size_m[0, :2] / 2, 2).tolist()
    top = float(np.max(geometry.center_enu_m[1:, 2] + geometry.size_m[1:, 2] / 2, initial=0.0))
    if skeleton.domain != "indoor":
        top = max(_OPEN_SKY_M, math.ceil(top + HEADROOM_M))
    return (-half_x, -half_y, 0.0), (half_x, half_y, round(top, 3))


def _draw_looks(
    skeleton: Skeleton, vocabulary: Vocabulary, rng: np.random.Generator
) -> list[dict[str, AttributeValue]]:
    """Colours and finishes as the corpus had them; like things in one room look alike."""
    drawn: dict[tuple[int, int], dict[str, AttributeValue]] = {}
    looks: list[dict[str, AttributeValue]] = [{}]
    for i in range(1, len(skeleton)):
        kind_id, parent = int(skeleton.kind_id[i]), int(skeleton.parent[i])
        alike = vocabulary.kinds[kind_id].domain == "indoor"
        key = (kind_id, parent if alike else -i)
        if key not in drawn:
            choices = vocabulary.looks[kind_id]
            weights = np.array([look.count for look in choices], dtype=float)
            drawn[key] = choices[rng.choice(len(choices), p=weights / weights.sum())].attributes
        looks.append(drawn[key])
    return looks
