"""Growth of a skeleton, object by object: first the coarse tree, then the fine objects.

The coarse objects come depth first, as many as are asked for. Then each of them that may bear fine
objects gets a quota, and one the start pad; then each fills its quota, depth first again. So no
step has to say that it is the last, and what is left is known at each.

Many skeletons grow at once, one a row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.skeleton.bucket import bucket
from aeroscene.learning.skeleton.path import Paths


class View(NamedTuple):
    """Input of the network before a step."""

    path: Int[np.ndarray, "r levels"]
    """Kinds along the path, see `Paths`."""
    n_children: Int[np.ndarray, "r levels"]
    """Children of the objects along the path, see `bucket`."""
    depth: Int[np.ndarray, " r"]
    counts: Int[np.ndarray, "r 3"]
    """What is left to place or to share out, and the like; see `bucket`."""
    flags: Bool[np.ndarray, "r 2"]
    """Whether quotas are being given; whether the start pad is due here."""
    focus: Int[np.ndarray, " r"]
    """Place of the coarse object that is being furnished; 0 while coarse ones are placed."""
    pressure: Float[np.ndarray, " r"]
    """Logarithm of what is left to share out over what the coarse objects ahead usually take."""


FOCUS = View._fields.index("focus")


class CoarseGrowth:
    """Coarse trees under sites."""

    def __init__(
        self,
        site: Int[np.ndarray, " r"],
        n_coarse: Int[np.ndarray, " r"],
        n_levels: int,
        n_kinds: int,
    ) -> None:
        self.paths = Paths(len(site), n_levels, n_kinds)
        self.paths.restart(np.arange(len(site)), site)
        self.n_left = n_coarse.copy()
        self.n_placed = np.zeros_like(n_coarse)

    @property
    def is_growing(self) -> Bool[np.ndarray, " r"]:
        """Rows where objects are still to come."""
        return self.n_left > 0

    def view(self) -> View:
        """What the network sees now."""
        n_roots = self.paths.n_children[:, 0]
        counts = np.stack([self.n_left, self.n_placed, n_roots], axis=-1)
        flags = np.zeros((len(counts), 2), dtype=bool)
        focus = np.zeros(len(counts), dtype=np.int64)
        pressure = np.zeros(len(counts), dtype=np.float32)
        return View(*self.paths.seen(), bucket(counts), flags, focus, pressure)

    def place(
        self, rows: Int[np.ndarray, " a"], depth: Int[np.ndarray, " a"], kind: Int[np.ndarray, " a"]
    ) -> None:
        """Add an object to some of the rows."""
        self.paths.place(rows, depth, kind)
        self.n_left[rows] -= 1
        self.n_placed[rows] += 1


class FineGrowth:
    """Fine objects on coarse ones: quotas first, then the objects."""

    def __init__(
        self,
        bearers: Bool[np.ndarray, "r coarse"],
        kind: Int[np.ndarray, "r coarse"],
        start: Int[np.ndarray, " r"],
        n_fine: Int[np.ndarray, " r"],
        usual: Float[np.ndarray, "r coarse"],
        n_levels: int,
        n_kinds: int,
    ) -> None:
        """Begin where the coarse part is complete.

        `start` is the place of the object that gets the start pad, -1 where there is no pad;
        `usual` are the quotas that such coarse objects have on average.
        """
        n_rows, self.n_places = bearers.shape
        self.bearers = bearers
        self.kind = kind
        self.start = start
        self._usual_ahead = (usual * bearers)[:, ::-1].cumsum(axis=1)[:, ::-1]
        self.quota = np.zeros_like(kind)
        self.n_unshared = n_fine.copy()
        self.n_to_plan = bearers.sum(axis=1)
        self.last_quota = np.zeros(n_rows, dtype=np.int64)
        self.n_left = np.zeros(n_rows, dtype=np.int64)
        self.is_due = np.zeros(n_rows, dtype=bool)
        self.is_planning = np.ones(n_rows, dtype=bool)
        self.focus = np.full(n_rows, -1)
        self.paths = Paths(n_rows, n_levels, n_kinds)
        self._go_on(np.arange(n_rows))

    @property
    def is_growing(self) -> Bool[np.ndarray, " r"]:
        """Rows where quotas or objects are still to come."""
        return self.focus < self.n_places

    def view(self) -> View:
        """What the network sees now."""
        rows, plans = np.arange(len(self.focus)), self.is_planning
        focus = np.minimum(self.focus, self.n_places - 1)
        counts = np.stack(
            [
                np.where(plans, self.n_unshared, self.n_left),
                np.where(plans, self.n_to_plan, self.quota[rows, focus]),
                self.last_quota * plans,
            ],
            axis=-1,
        )
        flags = np.stack([plans, self.is_due], axis=-1)
        pressure = np.log((self.n_unshared + 1.0) / (self._usual_ahead[rows, focus] + 1.0))
        pressure = np.where(plans, pressure, 0.0).astype(np.float32)
        return View(*self.paths.seen(), bucket(counts), flags, focus, pressure)

    def share(self, rows: Int[np.ndarray, " a"], quota: Int[np.ndarray, " a"]) -> None:
        """Give the coarse objects in focus their quotas."""
        self.quota[rows, self.focus[rows]] += quota
        self.n_unshared[rows] -= quota
        self.n_to_plan[rows] -= 1
        self.last_quota[rows] = quota
        self._go_on(rows)

    def top_up(self, row: int, extra: Int[np.ndarray, " coarse"]) -> None:
        """Raise quotas of a row that were given already."""
        self.quota[row] += extra
        self.n_unshared[row] -= extra.sum()

    def place(
        self,
        rows: Int[np.ndarray, " a"],
        depth: Int[np.ndarray, " a"],
        kind: Int[np.ndarray, " a"],
        is_start: Bool[np.ndarray, " a"],
    ) -> None:
        """Add an object to some of the rows."""
        self.paths.place(rows, depth, kind)
        self.n_left[rows] -= 1
        self.is_due[rows] &= ~is_start
        self._go_on(rows[self.n_left[rows] == 0])

    def _go_on(self, rows: np.ndarray) -> None:
        """Turn to the next coarse object: of those to plan first, then of those with a quota."""
        plans = self.is_planning[rows, None]
        wanted = np.where(plans, self.bearers[rows], self.quota[rows] > 0)
        focus = self._next(rows, wanted)
        planned = rows[self.is_planning[rows] & (focus == self.n_places)]
        self.focus[rows] = focus
        self.is_planning[planned] = False
        self.focus[planned] = -1
        self.focus[planned] = self._next(planned, self.quota[planned] > 0)
        rows = rows[self.focus[rows] < self.n_places]
        at = (rows, self.focus[rows])
        self.is_due[rows] = self.start[rows] == self.focus[rows]
        self.n_left[rows] = self.quota[at]
        self.paths.restart(rows, self.kind[at])

    def _next(self, rows: np.ndarray, wanted: Bool[np.ndarray, "a coarse"]) -> np.ndarray:
        places = np.arange(self.n_places)
        later = wanted & (places > self.focus[rows, None])
        return np.where(later.any(axis=1), later.argmax(axis=1), self.n_places)
