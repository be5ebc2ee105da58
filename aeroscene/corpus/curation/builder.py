"""Builder of a scene: it collects objects and refuses every one that would overlap.

The grammar therefore needs no bookkeeping: a place tries to put an object down and goes on without
it if it does not fit. Every scene is free of overlaps from the first object on, at any step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

from aeroscene.corpus.curation.frame import Frame
from aeroscene.scene import AttributeValue, ObjectDomain, OrientedBox, SceneObject, Vector3
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id
from aeroscene.scene.overlap import iou

Attributes = Mapping[str, AttributeValue]
"""Attributes of an object: its properties beyond the box."""
TOUCH_M = 0.001
"""Overlap up to which two boxes count as touching, m."""
_RESERVED = -1
"""Number of an occupant that is not an object but air to be kept free."""
MAX_IOU = 0.01
"""Largest overlap (intersection over union) of two boxes unless one is the other's parent."""


@dataclass(frozen=True, slots=True)
class Placed:
    """An object that stands in the scene, with the frame that its children use."""

    id: int
    name: str
    frame: Frame
    size: Vector3
    base: float
    domain: ObjectDomain

    @property
    def top(self) -> float:
        """Height of the upper face of the box, m."""
        return self.base + self.size[2]


@dataclass(frozen=True, slots=True)
class _Occupant:
    """An upright box in the form that the overlap test needs."""

    x: float
    y: float
    cos: float
    sin: float
    half_x: float
    half_y: float
    low: float
    high: float
    reach: float
    object_id: int

    def overlaps(self, other: _Occupant) -> bool:
        """Return true if two boxes share more than a touch."""
        if self.low >= other.high - TOUCH_M or other.low >= self.high - TOUCH_M:
            return False
        # Circles around both outlines decide most pairs without their axes.
        dx, dy = other.x - self.x, other.y - self.y
        reach = self.reach + other.reach
        if dx * dx + dy * dy >= reach * reach:
            return False
        # Upright boxes overlap if no axis separates them: heights are compared above, and each
        # outline has two axes.
        return self._is_near(other, dx, dy) and other._is_near(self, -dx, -dy)

    def _is_near(self, other: _Occupant, dx: float, dy: float) -> bool:
        """Return true if neither axis of this box separates the two outlines."""
        c = abs(self.cos * other.cos + self.sin * other.sin)
        s = abs(self.sin * other.cos - self.cos * other.sin)
        along = abs(dx * self.cos + dy * self.sin)
        across = abs(dy * self.cos - dx * self.sin)
        return (
            along < self.half_x + c * other.half_x + s * other.half_y - TOUCH_M
            and across < self.half_y + s * other.half_x + c * other.half_y - TOUCH_M
        )


class Builder:
    """The growing scene: every object gets the next id, so that parents precede children.

    Attributes:
        scene_id: Id of the scene.
        objects: Objects so far.
        n_coarse: Number of coarse objects so far.
        n_fine: Number of fine objects so far.
    """

    def __init__(self, scene_id: str) -> None:
        self.scene_id = scene_id
        self.objects: list[SceneObject] = []
        self.n_coarse = 0
        self.n_fine = 0
        self._occupants: list[_Occupant] = []
        self._ancestors: dict[int, frozenset[int]] = {}
        self._bounds: tuple[tuple[float, float], tuple[float, float]] | None = None

    def enclose(self, low: tuple[float, float], high: tuple[float, float]) -> None:
        """Refuse from now on every object that leaves an upright rectangle.

        Objects that stand already are not tested.

        Args:
            low: Lower corner, east and north, m.
            high: Upper corner, m.
        """
        self._bounds = (low, high)

    def place(
        self,
        name: str,
        spot: Frame,
        size: Vector3,
        *,
        base: float | None = None,
        parent: Placed | None = None,
        within: Placed | None = None,
        margin: float = 0.0,
        domain: ObjectDomain | None = None,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Put an object into the scene, or return None if it does not fit.

        Args:
            name: Category.
            spot: Place and heading of the centre.
            size: Full extents, m; rounded to millimetres.
            base: Height of the underside, m; by default the parent's top, or else the ground.
            parent: Object that carries or contains this one: the two may overlap. With the parent's
                own ancestors it may share as little as two strangers may.
            within: Object whose outline must hold this one's.
            margin: Distance to keep from everything else, m.
            domain: Indoor or outdoor; the parent's by default.
            look: Attributes of the object.
        """
        if base is None:
            base = parent.top if parent else 0.0
        # Rounded as files are, so that the test sees the sizes that readers will see.
        size = (round(size[0], 3), round(size[1], 3), round(size[2], 3))
        box = _occupant(spot, size, base, margin, len(self.objects))
        line = frozenset() if parent is None else self._ancestors[parent.id] | {parent.id}
        is_outside = within is not None and not _is_inside(spot, size, within)
        if is_outside or self._leaves_bounds(spot, size) or self._is_taken(box, line):
            return None
        domain = domain or (parent.domain if parent else "outdoor")
        obj = SceneObject(
            id=len(self.objects),
            scene_id=self.scene_id,
            parent_id=None if parent is None else parent.id,
            category_id=category_id(name),
            bbox=OrientedBox(
                (round(spot.x, 4), round(spot.y, 4), round(base + size[2] / 2, 4)),
                quat_from_yaw(spot.yaw),
                size,
            ),
            domain=domain,
            attributes=dict(look or {}),
        )
        # Ancestors were left out of the overlap test, because a room lies inside its building. An
        # object that fills most of a remote ancestor is refused here.
        if any(_share_too_much(obj, self.objects[i]) for i in line if i != obj.parent_id):
            return None
        self.objects.append(obj)
        self.n_coarse += obj.is_coarse
        self.n_fine += not obj.is_coarse
        # Without the margin, which is this object's wish and no claim on later ones.
        self._occupants.append(_occupant(spot, size, base, 0.0, obj.id))
        self._ancestors[obj.id] = line
        return Placed(obj.id, name, spot, size, base, domain)

    def reserve(self, spot: Frame, size: Vector3, base: float) -> None:
        """Keep a box of air free of every object that is placed from now on.

        Args:
            spot: Place and heading of its centre.
            size: Full extents, m.
            base: Height of its underside, m.
        """
        self._occupants.append(_occupant(spot, size, base, 0.0, _RESERVED))

    def is_free(
        self,
        spot: Frame,
        size: Vector3,
        base: float,
        inside: Placed | None = None,
        *,
        or_reserved: bool = False,
    ) -> bool:
        """Return true if nothing stands in a box, apart from the objects that contain it.

        Args:
            spot: Place and heading of the box.
            size: Full extents, m.
            base: Height of its underside, m.
            inside: Object that contains the box; its ancestors contain it as well.
            or_reserved: Count reserved air as free.
        """
        line = frozenset() if inside is None else self._ancestors[inside.id] | {inside.id}
        line |= {_RESERVED} if or_reserved else set()
        return not self._is_taken(_occupant(spot, size, base, 0.0, _RESERVED), line)

    def _leaves_bounds(self, spot: Frame, size: Vector3) -> bool:
        if self._bounds is None:
            return False
        (x0, y0), (x1, y1) = self._bounds
        c, s = abs(math.cos(spot.yaw)), abs(math.sin(spot.yaw))
        reach_x, reach_y = (c * size[0] + s * size[1]) / 2, (s * size[0] + c * size[1]) / 2
        return (
            spot.x - reach_x < x0 - TOUCH_M
            or spot.x + reach_x > x1 + TOUCH_M
            or spot.y - reach_y < y0 - TOUCH_M
            or spot.y + reach_y > y1 + TOUCH_M
        )

    def _is_taken(self, box: _Occupant, line: frozenset[int]) -> bool:
        return any(box.overlaps(other) for other in self._occupants if other.object_id not in line)


def _occupant(spot: Frame, size: Vector3, base: float, margin: float, object_id: int) -> _Occupant:
    half_x, half_y = size[0] / 2 + margin, size[1] / 2 + margin
    return _Occupant(
        spot.x,
        spot.y,
        math.cos(spot.yaw),
        math.sin(spot.yaw),
        half_x,
        half_y,
        base,
        base + size[2],
        math.hypot(half_x, half_y),
        object_id,
    )


def _share_too_much(first: SceneObject, second: SceneObject) -> bool:
    volumes = sorted((math.prod(first.bbox.s), math.prod(second.bbox.s)))
    # Sharing cannot exceed the smaller volume, so unequal boxes need no exact test.
    return volumes[0] > MAX_IOU * volumes[1] and iou(first.bbox, second.bbox) > MAX_IOU


def _is_inside(spot: Frame, size: Vector3, outer: Placed) -> bool:
    for su, sv in product((-0.5, 0.5), repeat=2):
        u, v = outer.frame.local(*spot.point(su * size[0], sv * size[1]))
        if abs(u) > outer.size[0] / 2 + TOUCH_M or abs(v) > outer.size[1] / 2 + TOUCH_M:
            return False
    return True
