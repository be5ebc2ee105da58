"""Handmade small yard: a container to land on, crates in the way and a lawn as alternative."""

import dataclasses
import math

from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import category_id

CONTAINER, CRATE = 1, 10
TOP_M = 2.5
START_ENU_M = (0.0, 0.0, 0.0)


def thing(number, category, center, size, parent=None, yaw_rad=0.0):
    return SceneObject(
        id=number,
        scene_id="yard",
        parent_id=parent,
        category_id=category_id(category),
        bbox=OrientedBox(center, (math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2)), size),
        domain="outdoor",
    )


def rectangle(number, center, half, object_id, drone_class="medium", surface="metal"):
    (x, y, z), (a, b) = center, half
    return InteractionArea(
        id=number,
        object_id=object_id,
        polygon=((x - a, y - b, z), (x + a, y - b, z), (x + a, y + b, z), (x - a, y + b, z)),
        centroid=center,
        radius=min(half),
        drone_class=drone_class,
        slope_rad=0.0,
        clearance_m=10.0,
        surface=surface,
    )


ON_CONTAINER = rectangle(0, (9.0, 0.0, TOP_M), (2.5, 1.1), CONTAINER)
ON_LAWN = rectangle(1, (9.0, 8.0, 0.0), (1.5, 1.5), None, surface="grass")
UNDER_THE_START = rectangle(2, (0.0, 0.0, 0.0), (1.0, 1.0), None, "small", "grass")


def yard(*, has_crates_on_top=False, areas=(ON_CONTAINER, ON_LAWN, UNDER_THE_START)):
    """Container 9 m east of the start, behind a row of crates, optionally with more on top."""
    objects = [thing(CONTAINER, "container", (9.0, 0.0, TOP_M / 2), (6.0, 2.4, TOP_M))]
    objects += [
        thing(CRATE + n, "crate", (4.0, y, 0.5), (1.0, 1.0, 1.0))
        for n, y in enumerate((-2.0, -0.5, 1.0))
    ]
    if has_crates_on_top:
        places = [(x, y) for x in (7.0, 8.0, 9.0, 10.0, 11.0) for y in (-0.6, 0.6)]
        objects += [
            thing(CRATE + 5 + n, "crate", (x, y, TOP_M + 0.25), (0.6, 0.6, 0.5), CONTAINER)
            for n, (x, y) in enumerate(places)
        ]
    return Scene(
        scene_id="yard",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-15.0, -15.0, 0.0),
        extent_max_enu_m=(25.0, 20.0, 12.0),
        start_position_enu_m=START_ENU_M,
        start_yaw_rad=0.3,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=tuple(objects),
        interaction_areas=tuple(areas),
    )


FAR_LAWN = rectangle(0, (45.0, 0.0, 0.0), (2.0, 2.0), None, surface="grass")


def field():
    """Open ground with a lawn 45 m east of the start."""
    crate = thing(CRATE, "crate", (20.0, 12.0, 0.5), (1.0, 1.0, 1.0))
    crate = dataclasses.replace(crate, scene_id="field")
    return Scene(
        scene_id="field",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-10.0, -15.0, 0.0),
        extent_max_enu_m=(55.0, 15.0, 12.0),
        start_position_enu_m=START_ENU_M,
        start_yaw_rad=0.0,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=(crate,),
        interaction_areas=(FAR_LAWN,),
    )
