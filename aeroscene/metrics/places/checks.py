"""Every check of places, and the goal that generated scenes should reach in it.

    views = [TopView(scene) for scene in scenes]
    for check in CHECKS:
        print(check.title, check.figure(views), check.unit, check.goal)

Statistics over a whole scene do not notice a boat on land or a chair that faces away from its
table, but people notice at once. A check judges objects of one kind, one value each. Its figure is
their mean or median over all scenes together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Shaped

from aeroscene.metrics.places import (
    backs,
    fronts,
    fulness,
    ground,
    order,
    precision,
    roads,
    screens,
    seating,
    spacing,
    stairs,
    walls,
)
from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene import Scene

Judge = Callable[[TopView], Shaped[np.ndarray, " k"]]
"""Function that gives one value for each judged object of a scene: True for a fault, or a
figure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceCheck:
    """One figure about a group of scenes, from the values of all objects judged in them."""

    key: str
    """Name of the check for programs."""
    title: str
    unit: str
    better: Literal["lower", "higher"] = "lower"
    goal: float
    """Value that generated scenes should reach, in the unit of the check."""
    judge: Judge
    is_median: bool = False
    """True if the figure is the median of the values, not their mean."""

    def figure(self, views: Sequence[TopView]) -> float:
        """Mean or median over all judged objects of these scenes; nan without any.

        Args:
            views: Scenes seen from above.

        Returns:
            The figure in the unit of the check: shares in percent.
        """
        # Objects of all scenes count alike, so a scene with many of them weighs more.
        values = np.concatenate([np.zeros(0), *(self.judge(view) for view in views)])
        if not len(values):
            return float("nan")
        # Shares are judged as numbers from 0 to 1, and reported in percent.
        scale = 100.0 if self.unit == "%" else 1.0
        return scale * float(np.median(values) if self.is_median else values.mean())


CHECKS: tuple[PlaceCheck, ...] = (
    PlaceCheck(
        key="loose_wall_ends",
        title="wall ends that touch no wall",
        unit="%",
        goal=5.0,
        judge=walls.loose_wall_ends,
    ),
    PlaceCheck(
        key="closed_outline",
        title="outline of a named room closed by walls, median",
        unit="%",
        better="higher",
        goal=98.0,
        judge=walls.closed_shares,
        is_median=True,
    ),
    PlaceCheck(
        key="patches",
        title="separate patches of road, pavement, plaza and parking",
        unit="a site",
        goal=1.4,
        judge=ground.patches,
    ),
    PlaceCheck(
        key="covered_site",
        title="hull of the site covered by ground",
        unit="%",
        better="higher",
        goal=95.0,
        judge=ground.covered_shares,
    ),
    PlaceCheck(
        key="remote_parking",
        title="parking lots off road, pavement and plaza",
        unit="%",
        goal=1.0,
        judge=ground.remote_parking,
    ),
    PlaceCheck(
        key="averted_fronts",
        title="buildings whose front looks away from their street",
        unit="%",
        goal=15.0,
        judge=fronts.averted_fronts,
    ),
    PlaceCheck(
        key="averted_chairs",
        title="chairs at a table turned off it",
        unit="%",
        goal=1.0,
        judge=seating.averted_chairs,
    ),
    PlaceCheck(
        key="averted_screens",
        title="screens on a table turned off who sits at it",
        unit="%",
        goal=5.0,
        judge=screens.averted_screens,
    ),
    PlaceCheck(
        key="wrong_way_vehicles",
        title="vehicles on the wrong side of the road",
        unit="%",
        goal=1.0,
        judge=roads.wrong_way_vehicles,
    ),
    PlaceCheck(
        key="lights_off_roads",
        title="traffic lights off the road",
        unit="%",
        goal=0.0,
        judge=roads.lights_off_roads,
    ),
    PlaceCheck(
        key="stranded_boats",
        title="boats not on water",
        unit="%",
        goal=0.0,
        judge=roads.stranded_boats,
    ),
    PlaceCheck(
        key="dead_end_stairs",
        title="stairs whose top meets no level",
        unit="%",
        goal=5.0,
        judge=stairs.dead_end_stairs,
    ),
    PlaceCheck(
        key="backs_off_walls",
        title="storage and kitchen furniture with its back off the walls",
        unit="%",
        goal=34.0,
        judge=backs.backs_off_walls,
    ),
    PlaceCheck(
        key="lone_plates",
        title="plates on tables without a chair",
        unit="%",
        goal=7.0,
        judge=seating.lone_plates,
    ),
    PlaceCheck(
        key="idle_bridges",
        title="bridges over neither water nor road",
        unit="%",
        goal=0.0,
        judge=roads.idle_bridges,
    ),
    PlaceCheck(
        key="uneven_desks",
        title="rows of desks, deviation of the spacing over its mean",
        unit="-",
        goal=0.05,
        judge=spacing.uneven_spacing,
    ),
    PlaceCheck(
        key="pinned",
        title="objects whose place a relation gives in both axes",
        unit="%",
        better="higher",
        goal=40.0,
        judge=order.is_pinned,
    ),
    PlaceCheck(
        key="in_rows",
        title="objects in rows and grids of equal ones",
        unit="%",
        better="higher",
        goal=14.0,
        judge=order.is_in_row,
    ),
    PlaceCheck(
        key="dwelling_fill",
        title="fine objects on 100 m2 of homes",
        unit="-",
        better="higher",
        goal=40.0,
        judge=fulness.dwelling_fill,
    ),
    PlaceCheck(
        key="work_fill",
        title="fine objects on 100 m2 of offices and shops",
        unit="-",
        better="higher",
        goal=30.0,
        judge=fulness.work_fill,
    ),
    PlaceCheck(
        key="ordinary_bedrooms",
        title="bedrooms between 9 and 25 m2",
        unit="%",
        better="higher",
        goal=90.0,
        judge=fulness.ordinary_bedrooms,
    ),
    PlaceCheck(
        key="built_share",
        title="ground of towns that buildings cover",
        unit="%",
        better="higher",
        goal=30.0,
        judge=fulness.built_shares,
    ),
    PlaceCheck(
        key="whole_centimetres",
        title="fine objects whose extents are whole centimetres",
        unit="%",
        better="higher",
        goal=95.0,
        judge=precision.whole_centimetres,
    ),
    PlaceCheck(
        key="narrow_gaps",
        title="fine objects within 5 mm of a neighbour that they do not touch",
        unit="%",
        goal=0.1,
        judge=precision.narrow_gaps,
    ),
)
"""Checks in the order in which they are printed."""


def place_figures(scenes: Sequence[Scene]) -> dict[str, float]:
    """Return figures of a group of scenes under the keys of `CHECKS`; nan if nothing is judged."""
    views = [TopView(scene) for scene in scenes]
    return {check.key: check.figure(views) for check in CHECKS}
