"""Numbers of a unit: how its place, height and sizes become channels, in both directions.

    channels  name                                                                          unit
    0, 1      u and v relative to the relation's own place: m where the relation pins them  m
              free ones inside the host: by the play there, +-1 touches its border          -
              free v beside it: by the distance from middle to middle along its side        -
    2, 3      cosine and sine of the heading relative to the relation's own                 -
    4         underside above the bearer's top or underside; host's top; host's underside   m
    5, 6      log extents; log ratio to the bearer's along them; less the bearer's          m
    7         log height; log ratio to bearer's; top above host's top; above the bearer's   m
    8, 9      gap between neighbours of a row and of a column                               m
    10 to 16  `OPENINGS`, offsets over half the length                                      m
    17, 18    tilt about the own axes                                                       rad

Heights and sizes have several readings. Which of them counts is chosen kind by kind, see
`aeroscene.learning.program.references`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from aeroscene.learning.program import kinds
from aeroscene.relations.hosts import level_m
from aeroscene.relations.plane import QUARTER, Half, Place, Rectangle, turned_reach_m
from aeroscene.relations.relation import Kind, Relation
from aeroscene.scene import OrientedBox, Vector3
from aeroscene.scene.box import MIN_SIZE_M

Scale = tuple[float, float]
"""Offset and factor that turn a channel into metres: offset + factor times channel."""
# Least play inside a host, as a share of its half extent: a wide object would else have none.
LEAST_PLAY = 0.3
BARE_M = 30.0
"""Sides of a site without ground."""
# Least and greatest extents, so that any number decodes to a box.
_LEAST_M = 0.05
_MOST_M = 500.0
_CENTIMETRE_M = 0.01
_ENDS_AT_LEVEL = 2
"""First reference of a height that is a difference from a level, see `size_and_base`."""
_BESIDE = frozenset({Kind.SIDE, Kind.FACING})


def scales(relation: Relation, host: Rectangle, reach_m: Half) -> tuple[Scale, Scale]:
    """Return how channels 0 and 1 give the residual of a unit.

    Args:
        relation: Relation of the unit to its host.
        host: The host seen from above.
        reach_m: Half extents of the unit along u and v.

    Returns:
        Scales of u and of v.
    """
    half_m = host.reach_m(relation.side)
    found: list[Scale] = []
    for axis in (0, 1):
        if relation.pinned[axis] or relation.kind == Kind.SEAT:
            found.append((0.0, 1.0))
        elif relation.kind in _BESIDE and axis == 0:
            found.append((half_m[0] + reach_m[0], 1.0))
        elif relation.kind in _BESIDE:
            found.append((0.0, half_m[1] + reach_m[1]))
        else:
            play_m = max(half_m[axis] - reach_m[axis], LEAST_PLAY * half_m[axis], _LEAST_M)
            found.append((0.0, play_m))
    return found[0], found[1]


BARE_SITE = Rectangle(Place(0.0, 0.0, 0.0), (BARE_M / 2, BARE_M / 2))
"""Host of objects without one, if the ground has no covers."""


def site_rectangle(kind: kinds.SiteKind, site: Float[np.ndarray, " 19"]) -> Rectangle:
    """Return the host of objects without one: about the origin, as large as the ground.

    Args:
        kind: Kind of the `site` record.
        site: Its channels.
    """
    # Clipped at exp(6.5), 665 m, as extents are.
    x_m, y_m = (math.exp(min(log, 6.5)) / 2 for log in site[5:7].tolist())
    yaw_rad = kind.turn * QUARTER + own_heading_rad(*site[3:5].tolist())
    return replace(BARE_SITE, half_m=turned_reach_m((x_m, y_m), yaw_rad))


def own_heading_rad(cos: float, sin: float) -> float:
    """Return the heading beyond its quarter turns; 0 if its channels are NaN."""
    return 0.0 if math.isnan(cos) or math.isnan(sin) else math.atan2(sin, cos)


def reach_of(relation: Relation, yaw_rad: float, half_m: Half) -> Half:
    """Return how far an object reaches along u and v.

    Args:
        relation: Relation that gives its quarter turns.
        yaw_rad: Its heading beyond them.
        half_m: Its half extents along its own axes.
    """
    return turned_reach_m(half_m, yaw_rad + relation.quadrant % 4 * math.pi / 2)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Boxes from which heights and sizes count."""

    bearer: OrientedBox | None
    """None on bare ground."""
    host: OrientedBox | None

    def along_m(self, yaw_rad: float) -> Half:
        """Return the bearer's extents along the axes of an object; NaN without a bearer."""
        if self.bearer is None:
            return math.nan, math.nan
        half_m = self.bearer.s[0] / 2, self.bearer.s[1] / 2
        x_m, y_m = turned_reach_m(half_m, self.bearer.yaw_rad - yaw_rad)
        return 2 * x_m, 2 * y_m


def _levels(box: OrientedBox | None) -> tuple[float, float]:
    return (0.0, 0.0) if box is None else (box.p[2] - box.s[2] / 2, box.p[2] + box.s[2] / 2)


def up_to_level(category: str, box: OrientedBox | None) -> OrientedBox | None:
    """Return a host's box without the part above the level that people walk on.

    Stairs beside a bridge lead to its deck, and not to its rails.
    """
    if box is None:
        return None
    low_m, level = _levels(box)[0], level_m(category, box)
    return OrientedBox((*box.p[:2], (low_m + level) / 2), box.q, (*box.s[:2], level - low_m))


def choices_of(
    around: Surroundings, size_m: Vector3, yaw_rad: float, base_m: float, *, is_on_top: bool
) -> Float[np.ndarray, "4 4"]:
    """Return the height of an underside and the three extents, from each reference.

    Args:
        around: Bearer and host.
        size_m: Extents of the unit.
        yaw_rad: Heading of the unit.
        base_m: Height of its underside.
        is_on_top: True counts from the bearer's top, not from its underside.

    Returns:
        A row for each number, a column for each reference; NaN where a reference does not exist.
    """
    low_m, top_m = _levels(around.bearer)
    host_low_m, host_top_m = _levels(around.host)
    upper_m = base_m + size_m[2]
    own_m = base_m - (top_m if is_on_top else low_m)
    rows = [[own_m, base_m - host_top_m, base_m - host_low_m, math.nan]]
    for extent_m, along_m in zip(size_m, around.along_m(yaw_rad), strict=False):
        log = math.log(extent_m)
        ratio = log - math.log(along_m) if along_m > 0 else math.nan
        rows.append([log, ratio, extent_m - along_m, math.nan])
    log, tall_m = math.log(size_m[2]), top_m - low_m
    ratio = log - math.log(tall_m) if tall_m > 0 else math.nan
    rows.append([log, ratio, upper_m - host_top_m, upper_m - top_m])
    return np.array(rows)


def size_and_base(
    around: Surroundings,
    values: Sequence[float],
    references: Sequence[int],
    yaw_rad: float,
    *,
    is_on_top: bool,
) -> tuple[Vector3, float]:
    """Return extents and the height of the underside; inverse of `choices_of`.

    Any values give a box. Args are those of `choices_of`, with the values and the reference of
    each.
    """
    rise, *sizes = values
    low_m, top_m = _levels(around.bearer)
    host_low_m, host_top_m = _levels(around.host)
    base_m = rise + (top_m if is_on_top else low_m, host_top_m, host_low_m)[references[0]]
    along_m = around.along_m(yaw_rad)
    x_m, y_m = (
        _extent(sizes[axis], references[1 + axis], along_m[axis], along_m[axis]) for axis in (0, 1)
    )
    upper_m = host_top_m if references[3] == 2 else top_m
    z_m = _extent(sizes[2], min(references[3], 2), top_m - low_m, upper_m - base_m)
    return (x_m, y_m, z_m), base_m


def _extent(value: float, reference: int, along_m: float, less_m: float) -> float:
    """Return an extent from its log, its log ratio to another, or its difference from another."""
    if math.isnan(along_m) or (reference == 1 and along_m <= 0):
        reference = 0
    if reference == 2:
        found_m = less_m + value
    else:
        found_m = math.exp(min(value, 6.5)) * (along_m if reference == 1 else 1.0)
    # To a tenth of a millimetre: single precision, in which statistics are kept, has no more.
    least_m = _LEAST_M if reference == 2 else MIN_SIZE_M
    return round(min(max(found_m, least_m), _MOST_M), 4)


def in_centimetres(size_m: Vector3, references: Sequence[int]) -> Vector3:
    """Round extents to whole centimetres.

    An extent that follows from the bearer's is rounded down, so that the object still fits there. A
    height that ends at a host's or bearer's level stays, because the object must reach this level.
    Extents below a centimetre stay too.

    Args:
        size_m: Extents.
        references: Reference of each, as `size_and_base` takes them.
    """
    x_m, y_m = (
        _rounded(extent_m, is_down=reference > 0)
        for extent_m, reference in zip(size_m[:2], references[:2], strict=True)
    )
    z_m = size_m[2] if references[2] >= _ENDS_AT_LEVEL else _rounded(size_m[2], is_down=False)
    return x_m, y_m, z_m


def _rounded(extent_m: float, *, is_down: bool) -> float:
    hundred = extent_m / _CENTIMETRE_M
    # Extents are kept to a tenth of a millimetre, so that 0.4 m may be 0.39999.
    whole = math.floor(hundred + 0.02) if is_down else round(hundred)
    return round(whole * _CENTIMETRE_M, 2) if whole > 0 else extent_m
