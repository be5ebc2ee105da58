"""Screens on tables, whose picture should face the nearest chair."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

from aeroscene.feasibility.seats import AT_TABLE_M
from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene.catalogue import SCREENS, SEATS, TABLES


def averted_screens(view: TopView) -> Bool[np.ndarray, " screens"]:
    """True for each screen on a table or desk that shows its back to the nearest chair.

    The picture faces along +x. A chair is at the table if the gap between the outlines of chair and
    table is at most `AT_TABLE_M` and they share height. Screens on other furniture, and on tables
    without a chair, are not judged.
    """
    screens, chairs = view.rows(SCREENS), view.rows(SEATS)
    screens = screens[view.is_on(TABLES)[screens]]
    tables = view.arrays.parent[screens]
    screen, chair = near_pairs(view.outline[tables], view.outline[chairs], AT_TABLE_M)
    table, screen, chair = tables[screen], screens[screen], chairs[chair]
    is_there = view.shared_height_m(table, chair) > 0
    screen, chair = screen[is_there], chair[is_there]
    way_m = view.centre_m[chair] - view.centre_m[screen]
    nearest = np.lexsort((np.linalg.norm(way_m, axis=1), screen))
    # Sorted by distance, so that the first row of each screen is its nearest chair.
    nearest = nearest[np.unique(screen[nearest], return_index=True)[1]]
    return (way_m[nearest] * view.forward[screen[nearest]]).sum(axis=1) < 0.0
