"""Leaps of the offset between estimate and map: one doubtful image alone brings none about.

An image that the map explains badly is matched again with a wider search. What is found then may be
another place that looks alike, such as the next of several shelves. If it is farther off than the
offset is known to, only a second image that finds the same is believed.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.perception.match import Match

_FAR = 3.0
"""Distance in standard deviations from which it is a leap."""
_ALIKE_M = 0.15
"""Greatest difference of two leaps to the same place."""
_TELLS_OF_PLACE = 3
"""Directions that an image determines at least if it tells of the place, not only of the height."""
_LASTS_S = 2.0
"""Time for which a leap waits for another one."""


class Leaps:
    """Remembers the leap that waits to be confirmed."""

    def __init__(self) -> None:
        self._waiting: tuple[float, Float[np.ndarray, " 3"]] | None = None

    def see(self, match: Match) -> None:
        """Forget a leap by an image of the place that the map explains without it."""
        if len(match.measured) >= _TELLS_OF_PLACE:
            self._waiting = None

    def is_first(
        self,
        time_s: float,
        match: Match,
        x: Float[np.ndarray, " 4"],
        covariance: Float[np.ndarray, "4 4"],
    ) -> bool:
        """Whether a match found after a doubt is a leap that no image before has told of.

        Args:
            time_s: Time of the image.
            match: The match that the wider search found.
            x: Offset and yaw before the doubt.
            covariance: Their covariance before the doubt.
        """
        if not len(match.measured):
            return False
        lack = match.measured - match.directions.T @ x
        spread = match.directions.T @ covariance @ match.directions + np.diag(match.variances)
        if math.sqrt(float(lack @ np.linalg.solve(spread, lack))) < _FAR:
            return False
        there = (x + match.directions @ lack)[:3]
        before, self._waiting = self._waiting, (time_s, there)
        if before is None or time_s - before[0] > _LASTS_S:
            return True
        return math.dist(before[1], there) > _ALIKE_M
