"""Plans on ground that is not flat: a hillside in bands, a quay, a canal."""

from __future__ import annotations

from math import pi

import numpy as np

from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import FLAT, Block, Land, Parcel, Rectangle, Side
from aeroscene.corpus.curation.site import Site

WALLS = ("stone", "brick", "dark_concrete")
"""Materials of retaining walls."""
_LANE_M = 4.5
"""Width of the lane on an upper terrace and of the ramp that leads to it."""
_TERRACE_M = 17.0
"""Least depth of a terrace with its parcels."""


def lay_hillside(site: Site, rng: np.random.Generator) -> None:
    """Lay a street at the foot, a slope with a ramp, and a terrace with a lane above it.

    A deep site has a second slope and terrace above the first. Parcels on terraces stand on raised
    ground.

    Args:
        site: Site, which gets roads, slopes and parcels.
        rng: Randomness of the plan.
    """
    hx, hy, w = site.half_x, site.half_y, site.road_m
    # Only a deep site has room for parcels below the street.
    foot_m = float(rng.uniform(15.0, 18.0)) if 2 * hy > 64 else 0.0
    street = -hy + foot_m + (site.walk_m if foot_m else 0.0) + w / 2
    site.lay_road(Frame(0, street, 0), 2 * hx)
    if foot_m:
        site.pave(Block(Rectangle(-hx, -hy, hx, street - w / 2), ("north",)), rng)
    foot = street + w / 2
    site.lay_sidewalk(Frame(0, foot, 0), 2 * hx)
    foot += site.walk_m
    level = 0.0
    land = FLAT
    n_terraces = max(1, min(2, int((hy - foot) // (_TERRACE_M + 14.0))))
    for number in range(n_terraces):
        run = round(float(rng.uniform(9.0, 13.0)), 2)
        # Gradients of 12 to 17 percent: steep for a street, gentle enough to land on.
        rise = round(run * float(rng.uniform(0.12, 0.17)), 2)
        _lay_slope(site, (foot, foot + run), land, rise, rng)
        level = round(level + rise, 2)
        top = hy if number == n_terraces - 1 else foot + run + _TERRACE_M + _LANE_M
        land = _lay_terrace(site, (foot + run, top), level, rng)
        foot = top


def _lay_slope(
    site: Site, span: tuple[float, float], land: Land, rise: float, rng: np.random.Generator
) -> None:
    """Lay grass on both sides of a ramp for vehicles, rising from the street."""
    hx = site.half_x
    low, high = span
    u = float(rng.uniform(-0.5, 0.5)) * hx
    ramp = (u - _LANE_M / 2, u + _LANE_M / 2)
    for west, east in ((-hx, ramp[0]), (ramp[1], hx)):
        frame = site.world(Frame((west + east) / 2, low, 0))
        parcel = Parcel(frame, east - west, high - low, land.level, rise, land.bearer)
        site.slopes.append(parcel)
    site.builder.place(
        "terrain",
        site.world(Frame(u, (low + high) / 2, pi / 2)),
        (high - low, _LANE_M, rise),
        base=land.level,
        parent=land.bearer,
        look={"form": "ramp", "finish": "asphalt"},
    )


def _lay_terrace(
    site: Site, span: tuple[float, float], level: float, rng: np.random.Generator
) -> Land:
    """Raise ground with a lane along its edge and parcels behind it."""
    hx = site.half_x
    low, high = span
    finish, wall = str(rng.choice(["concrete", "paving", "grass"])), str(rng.choice(WALLS))
    land = site.raise_land(Rectangle(-hx, low, hx, high), level, finish, wall)
    site.lay_road(Frame(0, low + _LANE_M / 2, 0), 2 * hx, width=_LANE_M, land=land)
    site.part(Rectangle(-hx, low + _LANE_M, hx, high), "south", rng, land=land)
    return land


def lay_quay(site: Site, rng: np.random.Generator) -> None:
    """Lay water along one side of raised ground, with a promenade on its edge."""
    hx, hy = site.half_x, site.half_y
    # Water takes a strip at the northern border.
    shore = hy - float(rng.uniform(13.0, 20.0))
    level, wall = round(float(rng.uniform(0.6, 1.1)), 2), str(rng.choice(WALLS))
    land = site.raise_land(Rectangle(-hx, -hy, hx, shore), level, "paving", wall)
    site.fill_with_water(Rectangle(-hx, shore, hx, hy), "south")
    _lay_promenade(site, "north", shore, land)
    edge = shore - site.walk_m
    street = shore - float(rng.uniform(21, 25)) - site.walk_m
    w = site.road_m
    site.lay_road(Frame(0, street, 0), 2 * hx, land=land)
    front = Rectangle(-hx, street + w / 2, hx, edge)
    site.pave(Block(front, ("south",), land), rng)
    south = street - w / 2
    # A shallow rest has no parcels, and gets a sidewalk alone.
    if south + hy > 14 + site.walk_m:
        site.pave(Block(Rectangle(-hx, -hy, hx, south), ("north",), land), rng)
    else:
        site.lay_sidewalk(Frame(0, south, pi), 2 * hx, land=land)


def _lay_promenade(site: Site, side: Side, shore: float, land: Land) -> None:
    """Lay a walk along the quay's edge, its lamps at the water."""
    turn = pi if side == "north" else 0.0
    site.lay_sidewalk(Frame(0, shore, turn), 2 * site.half_x, land=land)


def lay_canal(site: Site, rng: np.random.Generator) -> None:
    """Lay a canal between two banks, and a causeway with a street across it."""
    hx, hy, w = site.half_x, site.half_y, site.road_m
    y = float(rng.uniform(-0.15, 0.15)) * hy
    half = float(rng.uniform(4.5, 6.5))
    level, wall = round(float(rng.uniform(0.6, 1.0)), 2), str(rng.choice(WALLS))
    x = float(rng.uniform(-0.4, 0.4)) * hx
    # Half the causeway: a carriageway with a sidewalk on each side.
    dam = w / 2 + site.walk_m
    south = site.raise_land(Rectangle(-hx, -hy, hx, y - half), level, "paving", wall)
    north = site.raise_land(Rectangle(-hx, y + half, hx, hy), level, "paving", wall)
    dam_land = site.raise_land(
        Rectangle(x - dam, y - half, x + dam, y + half), level, "paving", wall
    )
    site.fill_with_water(Rectangle(-hx, y - half, x - dam, y + half), "south")
    site.fill_with_water(Rectangle(x + dam, y - half, hx, y + half), "south")
    site.lay_road(Frame(x, (y - half - hy) / 2, pi / 2), hy + y - half, land=south)
    site.lay_road(Frame(x, y, pi / 2), 2 * half, land=dam_land)
    site.lay_road(Frame(x, (y + half + hy) / 2, pi / 2), hy - y - half, land=north)
    for turn, sign in ((pi / 2, -1), (-pi / 2, 1)):
        site.lay_sidewalk(Frame(x + sign * w / 2, y, turn), 2 * half, land=dam_land)
    for area, side in (
        (Rectangle(-hx, -hy, x - w / 2, y - half), "north"),
        (Rectangle(-hx, y + half, x - w / 2, hy), "south"),
    ):
        site.pave(Block(area, ("east", side), south if side == "north" else north), rng)
    for area, side in (
        (Rectangle(x + w / 2, -hy, hx, y - half), "north"),
        (Rectangle(x + w / 2, y + half, hx, hy), "south"),
    ):
        site.pave(Block(area, ("west", side), south if side == "north" else north), rng)


def lay_shore(site: Site, rng: np.random.Generator) -> None:
    """Lay a street along the shore: one waterfront on its far side, parcels on the near side."""
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    y = hy - float(rng.uniform(24.0, 34.0)) - site.walk_m - half
    site.lay_road(Frame(0, y, 0), 2 * hx)
    site.pave(
        Block(Rectangle(-hx, y + half, hx, hy), ("south",), uses=("waterfront", "marina")), rng
    )
    site.pave(Block(Rectangle(-hx, -hy, hx, y - half), ("north",)), rng)
