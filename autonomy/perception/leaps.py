"""Leaps of the offset between estimate and map: one doubtful image alone causes none.

An image that the map explains badly is matched again with a wider search. The match may then be
another place that looks alike, such as the next of several shelves. If it is farther off than the
offset's uncertainty, it is believed only when a second image finds the same place.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.perception.match import Match

_FAR = 3.0
"""Distance in standard deviations from which a match is a leap."""
_ALIKE_M = 0.15
"""Greatest difference of two leaps that lead to the same place."""
_TELLS_OF_PLACE = 3
"""Number of directions that an image must determine to locate the vehicle, not only its height."""
_LASTS_S = 2.0
"""Time for which a leap waits for another one."""


class Leaps:
    """Memory of the leap that waits to be confirmed."""

    def __init__(self) -> None:
        self._waiting: tuple[float, Float[np.ndarray, " 3"]] | None = None

    def see(self, match: Match) -> None:
        """Forget a waiting leap if the map explains an image of the place without it."""
        if len(match.measured) >= _TELLS_OF_PLACE:
            self._waiting = None

    def is_first(
        self,
        time_s: float,
        match: Match,
        x: Float[np.ndarray, " 4"],
        covariance: Float[np.ndarray, "4 4"],
    ) -> bool:
        """Return whether a match found after a doubt is a leap that no image before has found.

        The leap then waits for another image.

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
