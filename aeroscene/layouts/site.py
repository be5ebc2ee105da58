"""The piece of world that a layout takes, and the fate of each of its objects there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.assembly import Assembly
from aeroscene.layouts.document import LayoutError, LayoutObject, NeutralLayout, Point2
from aeroscene.layouts.ground import Rectangle
from aeroscene.layouts.mapping import Fit, MappingReport, match, unknown_category
from aeroscene.scene import OrientedBox, Quaternion
from aeroscene.scene.box import quat_product

GROUND_M = 0.04
"""Thickness of the ground outdoors, whose upper face is the source's z = 0."""
FINISH_M = 0.02
"""Thickness of a room's floor, likewise."""
MOST_CLEAR_M = 6.0
"""Greatest height of rooms."""
MAX_SIDE_M = 160.0
"""Longest side of the ground. Free space of a longer one takes too long to compute, so the rest is
dropped.
"""
_MARGIN_M = 10.0
"""Width of ground around the objects of a layout without a floor."""
_OUTSIDE_M = 3.0
"""Distance by which the centre of an object may lie outside the ground's bounds."""
_QUARTER: Quaternion = (0.5**0.5, 0.0, 0.0, 0.5**0.5)

Grounds = Sequence[Sequence[BaseGeometry]]
"""Grounds on which a drone may start: outlines of floors, the preferred ones first."""


@dataclass(frozen=True, slots=True)
class KeptObject:
    """An object of the layout that is in our scene."""

    category: str
    """Our category."""
    box: OrientedBox
    """Box in our frame: front at +x, on our ground."""

    @property
    def low_m(self) -> float:
        """Height of its lowest point, m."""
        return float(self.box.corners()[:, 2].min())

    @property
    def top_m(self) -> float:
        """Height of its highest point, m."""
        return float(self.box.corners()[:, 2].max())


@dataclass(slots=True, kw_only=True)
class Site:
    """A layout on its way to a scene."""

    layout: NeutralLayout
    assembly: Assembly
    is_indoor: bool
    bounds: Rectangle
    """Bounds of the source's ground."""
    kept: dict[int, KeptObject] = field(default_factory=dict)
    """Objects that are kept, under their index in the layout."""
    mapped: Counter[tuple[str, str, Fit]] = field(default_factory=Counter)
    unmapped: Counter[str] = field(default_factory=Counter)
    unmapped_first: dict[str, str] = field(default_factory=dict)
    dropped: Counter[str] = field(default_factory=Counter)

    @property
    def lift_m(self) -> float:
        """Height of our ground's upper face, m."""
        return FINISH_M if self.is_indoor else GROUND_M

    @property
    def top_m(self) -> float:
        """Height of the source's highest object, m."""
        return max([kept.top_m for kept in self.kept.values()], default=self.lift_m)

    def report(self) -> MappingReport:
        """Report on the mapping of the layout's objects."""
        scene_id = self.layout.scene_id
        return MappingReport(
            n_scenes=1,
            n_objects=len(self.layout.objects),
            mapped=dict(self.mapped),
            unmapped=dict(self.unmapped),
            unmapped_first=self.unmapped_first,
            dropped=dict(self.dropped),
            invalid=tuple(f"scene {scene_id!r}: {line}" for line in self.layout.invalid),
        )


def survey(layout: NeutralLayout) -> Site:
    """Choose the ground and decide on every object.

    Raises:
        LayoutError: If there is no ground, it is too large for rooms, or nothing could be used.
    """
    site = Site(
        layout=layout,
        assembly=Assembly(layout.scene_id),
        is_indoor=layout.domain == "indoor",
        bounds=_bounds(layout),
    )
    for index, obj in enumerate(layout.objects):
        _decide(site, index, obj)
    if layout.objects and not site.kept:
        _refuse_all(site)
    return site


def _decide(site: Site, index: int, obj: LayoutObject) -> None:
    found = match(obj)
    if found is None:
        site.unmapped[obj.category] += 1
        where = f"scene {site.layout.scene_id!r}: object {index}"
        site.unmapped_first.setdefault(obj.category, where)
        return
    kept = KeptObject(found.category, our_box(obj, site.layout.front, site.lift_m))
    reason = _reason_to_drop(site, kept)
    if reason:
        site.dropped[reason] += 1
        return
    site.kept[index] = kept
    site.mapped[obj.category, found.category, found.fit] += 1


def our_box(obj: LayoutObject, front: str, lift_m: float) -> OrientedBox:
    """Box with its front turned to +x and lifted onto our ground.

    Args:
        obj: Object of the layout.
        front: Body axis of the source's front, x or y.
        lift_m: Height of our ground.
    """
    q, s = obj.q, obj.s
    # A quarter turn exchanges the two horizontal extents.
    if front == "y":
        q, s = quat_product(q, _QUARTER), (s[1], s[0], s[2])
    # w >= 0 and no negative zeros: equal attitudes give equal files.
    sign = -1.0 if q[0] < 0 else 1.0
    w, x, y, z = (round(sign * v, 9) + 0.0 for v in q)
    return OrientedBox((obj.p[0], obj.p[1], round(obj.p[2] + lift_m, 4)), (w, x, y, z), s)


def _reason_to_drop(site: Site, kept: KeptObject) -> str | None:
    x, y, _ = kept.box.p
    x0, y0, x1, y1 = site.bounds
    if not (x0 - _OUTSIDE_M <= x <= x1 + _OUTSIDE_M and y0 - _OUTSIDE_M <= y <= y1 + _OUTSIDE_M):
        return "outside the ground"
    if max(kept.box.s) > MAX_SIDE_M:
        return "larger than the ground may be"
    if kept.top_m <= site.lift_m:
        return "below the floor"
    if site.is_indoor and kept.low_m >= MOST_CLEAR_M:
        return "above the ceiling"
    return None


def _refuse_all(site: Site) -> NoReturn:
    objects = site.layout.objects
    first = f"object 0: {unknown_category(objects[0].category)}"
    if site.dropped:
        first = f"left out: {', '.join(site.dropped)}"
    raise LayoutError(f"none of its {len(objects)} objects could be used; {first}")


def _bounds(layout: NeutralLayout) -> Rectangle:
    outlines = [*([layout.floor] if layout.floor else []), *(r.polygon for r in layout.rooms)]
    points = [point for outline in outlines for point in outline] or _about_objects(layout)
    xs, ys = [x for x, _ in points], [y for _, y in points]
    sides = ((min(xs), max(xs)), (min(ys), max(ys)))
    if layout.domain == "indoor":
        longest_m = max(high - low for low, high in sides)
        if longest_m > MAX_SIDE_M:
            raise LayoutError(
                f"floor is {longest_m:.1f} m long; valid: at most {MAX_SIDE_M:g} m for rooms"
            )
        (x0, x1), (y0, y1) = sides
    else:
        (x0, x1), (y0, y1) = (_crop(layout, axis, *side) for axis, side in enumerate(sides))
    return (x0, y0, x1, y1)


def _about_objects(layout: NeutralLayout) -> list[Point2]:
    if not layout.objects:
        raise LayoutError("objects is empty and there is no floor; valid: one or the other")
    corners = [our_box(obj, layout.front, 0.0).corners()[:, :2] for obj in layout.objects]
    stacked = np.concatenate(corners)
    low, high = stacked.min(axis=0) - _MARGIN_M, stacked.max(axis=0) + _MARGIN_M
    return [(float(low[0]), float(low[1])), (float(high[0]), float(high[1]))]


def _crop(layout: NeutralLayout, axis: int, low: float, high: float) -> tuple[float, float]:
    """Limit a side to the length that can be searched, about the middle of the objects."""
    if high - low <= MAX_SIDE_M:
        return low, high
    places = [obj.p[axis] for obj in layout.objects] or [(low + high) / 2]
    # The median, because a single far object must not move the ground away from all others.
    middle = min(max(float(np.median(places)), low + MAX_SIDE_M / 2), high - MAX_SIDE_M / 2)
    return middle - MAX_SIDE_M / 2, middle + MAX_SIDE_M / 2
