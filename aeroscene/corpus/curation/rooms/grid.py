"""Places of a regular grid on the floor of a room."""

from __future__ import annotations


def grid_spots(
    size: tuple[float, float],
    clear_end_m: float,
    pitch: tuple[float, float],
    rim: float | tuple[float, float],
    *,
    is_tight: bool,
) -> list[tuple[float, float]]:
    """Places row by row along the room's x axis, from its middle.

    Args:
        size: Lengths of the room along x and y, m.
        clear_end_m: Part of the longer one that stays free, at its positive end.
        pitch: Least distances along x and y, m.
        rim: Distance from the walls, one or one along each axis, m.
        is_tight: True keeps the grid at its pitch about the middle; false spreads it over the room.
    """
    x, y = size
    shift_u, shift_v = 0.0, 0.0
    # The part that stays free is cut from the longer side, and the rest moves away from it.
    if y >= x:
        y, shift_v = y - clear_end_m, -clear_end_m / 2
    else:
        x, shift_u = x - clear_end_m, -clear_end_m / 2
    rim_u, rim_v = rim if isinstance(rim, tuple) else (rim, rim)
    n_u, step_u = _spread(x - 2 * rim_u, pitch[0])
    n_v, step_v = _spread(y - 2 * rim_v, pitch[1])
    if is_tight:
        step_u, step_v = pitch
    return [
        (shift_u + (i - (n_u - 1) / 2) * step_u, shift_v + (j - (n_v - 1) / 2) * step_v)
        for i in range(n_u)
        for j in range(n_v)
    ]


def _spread(length: float, pitch: float) -> tuple[int, float]:
    """Number of points at least a pitch apart that fit on a length, and their distance."""
    if length < 0:
        return (0, 0.0)
    # n places have n - 1 distances between them.
    count = int(length // pitch) + 1
    return (count, length / (count - 1) if count > 1 else 0.0)


def middle_first(spots: list[tuple[float, float]], *, along: int = 1) -> list[tuple[float, float]]:
    """Order places so that all rows grow alike, each from its middle.

    Rows run along y, or along x if `along` is 0.
    """
    return sorted(spots, key=lambda spot: (abs(spot[along]), spot[along], spot[1 - along]))
