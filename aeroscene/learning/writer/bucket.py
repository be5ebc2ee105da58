"""Counts as a few classes, fine where counts are small.

The writer reads how many objects are still wished for. The difference between 2 and 3 matters, the
difference between 102 and 103 does not.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Int

N_BUCKETS = 24
_EXACT = 12
"""Counts below this have a class each. Above it, a class spans a quarter of an e-fold."""
_TABLE = np.array(
    [*range(_EXACT), *(_EXACT + int(4 * np.log(n / _EXACT)) for n in range(_EXACT, 256))]
).clip(max=N_BUCKETS - 1)


def bucket(count: Int[np.ndarray, "*n"]) -> Int[np.ndarray, "*n"]:
    """Return the classes of counts from 0; the greatest class has no upper end."""
    return _TABLE[np.minimum(count, len(_TABLE) - 1)]
