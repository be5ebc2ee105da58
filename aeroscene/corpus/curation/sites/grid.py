"""Plans of straight streets: through, tee, cross, loop, square, cul-de-sac."""

from __future__ import annotations

from math import pi

import numpy as np

from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import FLAT, Block, Land, Rectangle
from aeroscene.corpus.curation.site import Site

_HEAD_M = 12.0
"""Side of the square at the end of a cul-de-sac."""


def lay_through(site: Site, rng: np.random.Generator, land: Land = FLAT) -> None:
    """Lay one street across the site, nearer to one side.

    Args:
        site: Site, which gets roads, sidewalks and parcels.
        rng: Randomness of the plan.
        land: Ground that carries everything.
    """
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    # Off the middle, so that parcels on both sides differ in depth.
    y = float(rng.uniform(-0.3, 0.3)) * hy
    site.lay_road(Frame(0, y, 0), 2 * hx, land=land)
    site.pave(Block(Rectangle(-hx, -hy, hx, y - half), ("north",), land), rng)
    site.pave(Block(Rectangle(-hx, y + half, hx, hy), ("south",), land), rng)


def lay_tee(site: Site, rng: np.random.Generator, land: Land = FLAT) -> None:
    """Lay a street that ends on another; see `lay_through`."""
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    x, y = float(rng.uniform(-0.3, 0.3)) * hx, float(rng.uniform(-0.25, 0.12)) * hy
    _lay_arms(site, (x, y), land, has_south=False)
    site.pave(Block(Rectangle(-hx, -hy, hx, y - half), ("north",), land), rng)
    _pave_north(site, (x, y), land, rng)


def lay_cross(site: Site, rng: np.random.Generator, land: Land = FLAT) -> None:
    """Lay two streets that cross off the middle; see `lay_through`."""
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    x, y = (rng.uniform(-0.25, 0.25, 2) * (hx, hy)).tolist()
    _lay_arms(site, (x, y), land, has_south=True)
    south = y - half
    site.pave(Block(Rectangle(-hx, -hy, x - half, south), ("north", "east"), land), rng)
    site.pave(Block(Rectangle(x + half, -hy, hx, south), ("north", "west"), land), rng)
    _pave_north(site, (x, y), land, rng)


def _lay_arms(site: Site, at: tuple[float, float], land: Land, *, has_south: bool) -> None:
    """Lay the street along x, and the arms that meet it."""
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    x, y = at
    site.lay_road(Frame(0, y, 0), 2 * hx, land=land)
    site.junctions.append(site.world(Frame(x, y, 0)))
    north, south = y + half, y - half
    # The crossing for people is at the junction's end of each arm.
    site.lay_road(Frame(x, (north + hy) / 2, pi / 2), hy - north, zebra_end=-1, land=land)
    if has_south:
        site.lay_road(Frame(x, (south - hy) / 2, pi / 2), hy + south, zebra_end=1, land=land)


def _pave_north(site: Site, at: tuple[float, float], land: Land, rng: np.random.Generator) -> None:
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    x, north = at[0], at[1] + half
    site.pave(Block(Rectangle(-hx, north, x - half, hy), ("south", "east"), land), rng)
    site.pave(Block(Rectangle(x + half, north, hx, hy), ("south", "west"), land), rng)


def lay_loop(site: Site, rng: np.random.Generator) -> None:
    """Lay a street that turns twice and leaves where it came from, around a block."""
    hx, hy, w = site.half_x, site.half_y, site.road_m
    x = float(rng.uniform(-0.12, 0.12)) * hx
    a = float(rng.uniform(0.3, 0.42)) * hx
    top = float(rng.uniform(0.0, 0.25)) * hy
    # Inner edges of the two arms; the carriageways lie outside of them.
    west, east = x - a, x + a
    middle, length = (top - hy) / 2, top + hy
    site.lay_road(Frame(west - w / 2, middle, pi / 2), length, zebra_end=1)
    site.lay_road(Frame(east + w / 2, middle, pi / 2), length)
    site.lay_road(Frame(x, top + w / 2, 0), east - west + 2 * w)
    site.pave(Block(Rectangle(west, -hy, east, top), ("north", "west", "east")), rng)
    site.pave(Block(Rectangle(-hx, -hy, west - w, top + w), ("east",)), rng)
    site.pave(Block(Rectangle(east + w, -hy, hx, top + w), ("west",)), rng)
    site.pave(Block(Rectangle(-hx, top + w, hx, hy), ("south",)), rng)


def lay_square(site: Site, rng: np.random.Generator) -> None:
    """Lay four streets around a square, each leaving it in its own direction."""
    hx, hy, w = site.half_x, site.half_y, site.road_m
    # Each street runs past the corner of the square, like the arms of a pinwheel.
    a, b = (rng.uniform(0.27, 0.36, 2) * (hx, hy)).tolist()
    site.lay_road(Frame((a - hx) / 2, -b - w / 2, 0), hx + a, zebra_end=1)
    site.lay_road(Frame(a + w / 2, (b - hy) / 2, pi / 2), hy + b, zebra_end=1)
    site.lay_road(Frame((hx - a) / 2, b + w / 2, 0), hx + a, zebra_end=-1)
    site.lay_road(Frame(-a - w / 2, (hy - b) / 2, pi / 2), hy + b, zebra_end=-1)
    sides = ("south", "east", "north", "west")
    site.pave(Block(Rectangle(-a, -b, a, b), sides, uses=("square", "market", "park")), rng)
    site.pave(Block(Rectangle(-hx, -hy, a, -b - w), ("north", "east")), rng)
    site.pave(Block(Rectangle(a + w, -hy, hx, b), ("west", "north")), rng)
    site.pave(Block(Rectangle(-a, b + w, hx, hy), ("south", "west")), rng)
    site.pave(Block(Rectangle(-hx, -b, -a - w, hy), ("east", "south")), rng)


def lay_cul_de_sac(site: Site, rng: np.random.Generator) -> None:
    """Lay a street that ends in a turning head, with verges beside the carriageway."""
    hx, hy, half = site.half_x, site.half_y, site.road_m / 2
    x = float(rng.uniform(-0.15, 0.15)) * hx
    head = float(rng.uniform(0.0, 0.2)) * hy
    foot, side = head - _HEAD_M / 2, _HEAD_M / 2
    site.lay_road(Frame(x, (foot - hy) / 2, pi / 2), hy + foot)
    site.lay_road(Frame(x, head, pi / 2), _HEAD_M, width=_HEAD_M)
    for sign, turn in ((-1, pi / 2), (1, -pi / 2)):
        frame = Frame(x + sign * half, (foot - hy) / 2, turn)
        site.lay_verge(frame, hy + foot, side - half)
    top = head + side
    site.pave(Block(Rectangle(-hx, -hy, x - side, top), ("east",)), rng)
    site.pave(Block(Rectangle(x + side, -hy, hx, top), ("west",)), rng)
    site.pave(Block(Rectangle(-hx, top, hx, hy), ("south",)), rng)
