"""Search for the four cuts of a pinwheel: each ends on the next, and none crosses anything.

A pinwheel has no cut from side to side, so slices and crosses miss it. Rooms around a central hall
are an example.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

Cuts = tuple[int, int, int, int]
"""Lines at the sides of the middle: west, east, south, north."""


def find_pinwheel(
    can_cut_x: Bool[np.ndarray, "cuts rows"], can_cut_y: Bool[np.ndarray, "columns cuts"]
) -> tuple[bool, Cuts] | None:
    """Find the pinwheel with the largest middle.

    Args:
        can_cut_x: True if the line before column i + 1 crosses nothing in row j.
        can_cut_y: True if the line before row j + 1 crosses nothing in column i.

    Returns:
        True if it is mirrored, and its cuts; None if there is none.
    """
    for is_mirrored in (False, True):
        # The mirror image in x of a pinwheel is a pinwheel of the other hand.
        x = can_cut_x[::-1] if is_mirrored else can_cut_x
        y = can_cut_y[::-1] if is_mirrored else can_cut_y
        cuts = _find(x, y)
        if cuts:
            west, east, south, north = cuts
            # Lines of the mirror image count from the other side.
            n = len(can_cut_y)
            return is_mirrored, (n - east, n - west, south, north) if is_mirrored else cuts
    return None


def _find(x: np.ndarray, y: np.ndarray) -> Cuts | None:
    """Find the one whose eastern cut begins at the south; lines are numbered from 1."""
    n_columns, n_rows = len(y), x.shape[1]
    # How far the line before each column can run from the south and from the
    # north, and likewise rows.
    north_of = [_run(x[i]) for i in range(n_columns - 1)]
    south_of = [n_rows - _run(x[i, ::-1]) for i in range(n_columns - 1)]
    east_of = [_run(y[:, j]) for j in range(n_rows - 1)]
    west_of = [n_columns - _run(y[::-1, j]) for j in range(n_rows - 1)]
    best: tuple[int, Cuts] | None = None
    for east in range(2, n_columns):
        for north in range(2, min(n_rows - 1, north_of[east - 1]) + 1):
            for west in range(max(1, west_of[north - 1]), east):
                for south in range(max(1, south_of[west - 1]), north):
                    # Three cuts meet by the ranges of the loops; the southern one is checked here.
                    size = (east - west) * (north - south)
                    if east_of[south - 1] >= east and (best is None or size > best[0]):
                        best = (size, (west, east, south, north))
    return best[1] if best else None


def _run(row: np.ndarray) -> int:
    """Return the number of entries from the first on that are true."""
    return len(row) if row.all() else int(row.argmin())
