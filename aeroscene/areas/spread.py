"""Well spread choices among many places: farthest point first.

Limits leave out many places of a scene. Taking the first ones would leave parts of the scene
without any area.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from aeroscene.scene import Vector3

T = TypeVar("T")


def spread(
    places_enu_m: Sequence[Vector3],
    origin_enu_m: Vector3,
    limit: int | None,
    develop: Callable[[int], T | None],
    first: Sequence[int] = (),
) -> list[T]:
    """Choose places so that each is as far as possible from those before it.

    A place is developed only when its turn comes, and one that comes to nothing makes room for the
    next. Places that a limit leaves out are therefore never computed.

    Args:
        places_enu_m: Places of the candidates.
        origin_enu_m: The first choice is the place farthest from here.
        limit: Greatest number of choices; None takes all in their own order.
        develop: Makes the result from the number of a place, or None.
        first: Numbers of places that come before all others.
    """
    if limit is None:
        made = (develop(index) for index in range(len(places_enu_m)))
        return [item for item in made if item is not None]
    places = np.array(places_enu_m, dtype=float).reshape(-1, 3)
    from_origin_m = np.linalg.norm(places - origin_enu_m, axis=1)
    from_chosen_m = np.full(len(places), np.inf)
    is_left = np.ones(len(places), dtype=bool)
    queue = list(first)
    chosen: list[T] = []
    while is_left.any() and len(chosen) < limit:
        distance_m = from_chosen_m if chosen else from_origin_m
        index = queue.pop(0) if queue else int(np.argmax(np.where(is_left, distance_m, -1.0)))
        is_left[index] = False
        item = develop(index)
        if item is not None:
            # Places that came to nothing keep nobody away.
            chosen.append(item)
            from_this_m = np.linalg.norm(places - places[index], axis=1)
            from_chosen_m = np.minimum(from_chosen_m, from_this_m)
    return chosen
