"""Counts as a few classes, fine where small."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int

N_BUCKETS = 24
_EXACT = 12
"""Counts below are told apart; above, a class spans a quarter of an e-fold."""
_TABLE = np.array(
    [*range(_EXACT), *(_EXACT + int(4 * np.log(n / _EXACT)) for n in range(_EXACT, 256))]
).clip(max=N_BUCKETS - 1)


def bucket(count: Int[np.ndarray, "*n"]) -> Int[np.ndarray, "*n"]:
    """Classes of counts from 0."""
    return _TABLE[np.minimum(count, len(_TABLE) - 1)]
