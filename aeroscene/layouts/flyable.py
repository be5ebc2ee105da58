"""Layouts as scenes to fly in: a ground, walls about rooms, a start, landing areas.

Sources hold only furniture and outlines, so this module adds:

- Ground. Outdoors it is lawn over the floor's outline, indoors a room object for each rectangle of
  each room. The source's z = 0 becomes its upper face.
- Walls about rooms with openings between neighbours, see `walls`. They are as high as the tallest
  object asks, at least 3 m.
- A roof over all rooms, so that a flight from one room to the next leads through openings, and a
  yard about the house with one opening to it. Rooms of real furniture are often too full for an
  Iris.
- The uppermost 0.25 m of a building as its roof, an object of its own on which a drone may land.
- The start: the middle of a wide free disc, on a floor from which a landing area can be reached,
  otherwise in the yard.

Nothing is moved: overlaps of the source stay, and tilted boxes stay tilted.
"""

from __future__ import annotations

import numpy as np

from aeroscene.areas.start import NO_START, Ground, with_start
from aeroscene.layouts.document import LayoutError, NeutralLayout
from aeroscene.layouts.house import build_house, lay_ground
from aeroscene.layouts.mapping import MappingReport
from aeroscene.layouts.placement import place_objects
from aeroscene.layouts.site import Grounds, Site, survey
from aeroscene.scene import Scene, SceneDomain, Vector3
from aeroscene.scene.catalogue import LAWNS, ROOMS
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

SKY_M = 6.0
"""Free height above the tallest object outdoors."""
MAX_TOP_M = 60.0
"""Top of the flight volume, whatever is taller."""
_OVERHANG_M = 10.0
"""Distance by which the flight volume extends beyond the ground for objects over its edge."""


def map_layout(layout: NeutralLayout) -> MappingReport:
    """Report on the mapping of a layout's objects, without building the scene.

    Args:
        layout: Layout.

    Raises:
        LayoutError: If nothing of it could be used.
    """
    try:
        return survey(layout).report()
    except LayoutError as error:
        raise error.within(f"scene {layout.scene_id!r}") from None


def make_flyable(layout: NeutralLayout) -> tuple[Scene, MappingReport]:
    """Build the scene of a layout.

    Args:
        layout: Layout.

    Returns:
        The scene, and a report on the mapping of its objects.

    Raises:
        LayoutError: If nothing of it could be used, or there is no free place to start from.
    """
    try:
        site = survey(layout)
        if site.is_indoor:
            grounds, top_m = build_house(site)
        else:
            grounds, top_m = lay_ground(site), site.top_m
        place_objects(site)
        return _with_start(site, grounds, round(top_m + SKY_M, 3)), site.report()
    except LayoutError as error:
        raise error.within(f"scene {layout.scene_id!r}") from None


def _with_start(site: Site, grounds: Grounds, top_m: float) -> Scene:
    """The scene with the first start from which a landing area can be reached, or the best one."""
    ranks = [[Ground(region, site.lift_m) for region in regions] for regions in grounds]
    found = with_start(_scene(site, top_m), ranks)
    if found is None:
        raise LayoutError(f"floor has {NO_START}")
    return found


def _scene(site: Site, top_m: float) -> Scene:
    """The scene without a start and areas, which come later."""
    low, high = _extent(site, top_m)
    has_indoor = any(obj.domain == "indoor" for obj in site.assembly.objects)
    domain: SceneDomain = "indoor" if site.is_indoor else "mixed" if has_indoor else "outdoor"
    return Scene(
        scene_id=site.layout.scene_id,
        domain=domain,
        seed=0,
        extent_min_enu_m=low,
        extent_max_enu_m=high,
        # A start inside the volume, as the schema asks for, until the real one is found.
        start_position_enu_m=low,
        start_yaw_rad=0.0,
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=tuple(site.assembly.objects),
    )


def _extent(site: Site, top_m: float) -> tuple[Vector3, Vector3]:
    """The flight volume: the ground, objects that extend a little over its edge, and air above."""
    grounds = [obj for obj in site.assembly.objects if obj.category in LAWNS | ROOMS]
    ground = np.concatenate([obj.bbox.corners() for obj in grounds])
    corners = np.concatenate([obj.bbox.corners() for obj in site.assembly.objects])
    # Objects far beyond the ground must not make the volume large.
    low = np.maximum(corners.min(axis=0), ground.min(axis=0) - _OVERHANG_M)
    high = np.minimum(corners.max(axis=0), ground.max(axis=0) + _OVERHANG_M)
    top_m = min(max(top_m, float(corners[:, 2].max())), MAX_TOP_M)
    return (
        (round(float(low[0]), 3), round(float(low[1]), 3), 0.0),
        (round(float(high[0]), 3), round(float(high[1]), 3), round(top_m, 3)),
    )
