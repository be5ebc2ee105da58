"""How many fine objects each coarse one may get, and where the rest goes that none took."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int


class Quotas:
    """Quotas of many skeletons while they are drawn."""

    def __init__(
        self, least: Int[np.ndarray, "r coarse"], most: Int[np.ndarray, "r coarse"], n_quotas: int
    ) -> None:
        """Begin undrawn, with what each coarse object needs and what it may have."""
        self._least = least
        self._most = most
        self._ahead = least[:, ::-1].cumsum(axis=1)[:, ::-1] - least
        self._sizes = np.arange(n_quotas)
        # What was not spoken of stays at nothing, and no quota goes beyond the greatest.
        self._step = np.full((*least.shape, n_quotas), np.inf)

    def allowed(
        self,
        rows: Int[np.ndarray, " r"],
        places: Int[np.ndarray, " r"],
        n_unshared: Int[np.ndarray, " r"],
    ) -> Bool[np.ndarray, "r quotas"]:
        """Which quotas some coarse objects may get so that those ahead get what they need."""
        at = (rows, places)
        low = np.minimum(self._least[at], n_unshared)
        high = np.minimum(self._most[at], np.maximum(low, n_unshared - self._ahead[at]))
        return np.asarray(self._sizes >= low[:, None]) & (self._sizes <= high[:, None])

    def note(
        self,
        rows: Int[np.ndarray, " r"],
        places: Int[np.ndarray, " r"],
        logits: Float[np.ndarray, "r quotas"],
    ) -> None:
        """Keep how much each step from a quota to the next surprises the network."""
        step = -np.diff(logits, axis=1, append=-np.inf)
        step[self._sizes >= self._most[rows, places, None]] = np.inf
        self._step[rows, places] = step

    def share_rest(
        self, row: int, quota: Int[np.ndarray, " coarse"], rest: int
    ) -> Int[np.ndarray, " coarse"]:
        """Raise the quotas of a skeleton one by one, each time where that surprises least.

        Returns:
            What each coarse object gets on top; less than the rest in all where each has all that
            it may have.
        """
        places = np.arange(len(quota))
        extra = np.zeros_like(quota)
        for _ in range(rest):
            cost = self._step[row, places, quota + extra]
            best = int(cost.argmin())
            if not np.isfinite(cost[best]):
                break
            extra[best] += 1
        return extra
