"""Plans with more green than street: a park beside a road, and one with paths alone."""

from __future__ import annotations

from math import pi

import numpy as np

from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Rectangle, cut_unequal
from aeroscene.corpus.curation.site import Site

_PARCEL_M = 38.0
"""Typical width of parcels between paths."""


def lay_green_edge(site: Site, rng: np.random.Generator) -> None:
    """Lay a street along the southern border, and parcels in two rows north of it."""
    hx, hy, w = site.half_x, site.half_y, site.road_m
    road = -hy + site.walk_m + w / 2
    site.lay_sidewalk(Frame(0, road - w / 2, pi), 2 * hx)
    site.lay_road(Frame(0, road, 0), 2 * hx)
    site.lay_sidewalk(Frame(0, road + w / 2, 0), 2 * hx)
    low = road + w / 2 + site.walk_m
    # Both rows face south, across the street or the path before them.
    middle = (low + hy) / 2 + float(rng.uniform(-0.1, 0.1)) * (hy - low)
    site.part(Rectangle(-hx, low, hx, middle), "south", rng)
    site.lay_sidewalk(Frame(0, middle, 0), 2 * hx)
    site.part(Rectangle(-hx, middle + site.walk_m, hx, hy), "south", rng)


def lay_paths(site: Site, rng: np.random.Generator) -> None:
    """Lay paths that cross, without any street."""
    hx, hy, w = site.half_x, site.half_y, site.walk_m
    y = float(rng.uniform(-0.2, 0.2)) * hy
    site.lay_sidewalk(Frame(0, y - w / 2, 0), 2 * hx)
    for low, high, front in ((-hy, y - w / 2, "north"), (y + w / 2, hy, "south")):
        cuts = cut_unequal(2 * hx, rng, _PARCEL_M)
        for index, (west, east) in enumerate(cuts):
            area = Rectangle(west, low, east, high)
            if index:
                frame, length, _ = area.side_frame("west")
                site.lay_sidewalk(frame, length)
                # The path takes its width from the parcel to the east of it.
                area = area.without("west", w)
            site.part(area, front, rng)
