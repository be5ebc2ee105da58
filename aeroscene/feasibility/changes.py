"""The unknowns of a projection in the plane: displacements of objects, and cuts at their faces.

Objects move together with the object that carries them, so a displacement is relative to that. A
cut takes a slice off one face of a box and moves nothing else. Cuts matter for surfaces: moving a
lawn out of a road would carry its trees along, cutting it leaves them where they are.

| symbol | name | unit |
|---|---|---|
| x | displacements east, displacements north, cuts; one vector | m |
| face | 0 and 1 towards a box's own x and y, 2 and 3 away from them | - |
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import cuttable, least_m
from aeroscene.scene.catalogue import GROUND

NARROW_M = 8.0
"""Length of a side from which cuts cost less and may go deeper."""
DEEPEST_CUT = (0.2, 0.6)
"""Share of a side, narrow and wide, that both its cuts together may take."""
_CUT_COST = 0.3
"""Cost of a metre cut off a wide side, in displaced objects."""
_NO_CUT_M = 1e-9
_GROUND_FACTOR = 3.0
"""Cost of moving ground, relative to that of moving its objects: everything else makes room for it.
"""


class Changes:
    """The unknowns, their costs, and rows of demands on them.

    Attributes:
        carries: One if a movable object (column) carries an object (row), else zero.
        width: Number of unknowns.
        is_cuttable: True for objects that have cuts among the unknowns.
        costs: Cost of a metre of each unknown.
    """

    def __init__(self, layout: Layout, began: Boxes, movable: Int[np.ndarray, " m"]) -> None:
        """Set up the unknowns.

        Args:
            layout: Layout to be changed.
            began: Boxes before any change, with obstacles behind those of the layout.
            movable: Rows of the objects that may move or be cut.
        """
        n, m = len(layout.boxes), len(movable)
        self._began = began
        self._movable = movable
        self.carries: Float[np.ndarray, "n m"] = np.zeros((len(began), m))
        """One if a movable object (column) carries an object (row)."""
        self.carries[:n] = layout.moves_with[:, movable]
        is_cuttable = np.array([cuttable(layout.objects[row]) for row in movable], dtype=bool)
        self._cut_of, self._cut_axis = np.nonzero(is_cuttable.reshape(m, 2))
        least = np.array([least_m(layout.objects[row]) for row in movable]).reshape(m, 2)
        spare = self._sides() - least[self._cut_of, self._cut_axis]
        self._spare_m: Float[np.ndarray, " c"] = spare.clip(min=0.0)
        c = len(self._cut_of)
        # Two displacements for each movable object, and a cut at both ends of each cuttable side.
        self.width = 2 * m + 2 * c
        self._column = np.full((len(began), 4), -1)
        rows = movable[self._cut_of]
        self._column[rows, self._cut_axis] = 2 * m + np.arange(c)
        self._column[rows, self._cut_axis + 2] = 2 * m + c + np.arange(c)
        self.is_cuttable: Bool[np.ndarray, " n"] = self._column.max(axis=1) >= 0
        self.costs = self._count_costs(layout)

    def _count_costs(self, layout: Layout) -> Float[np.ndarray, " v"]:
        """Cost of a metre of each change: the number of objects that it displaces."""
        carried = layout.moves_with[:, self._movable] & layout.is_present[:, None]
        is_ground = [layout.objects[row].category in GROUND for row in self._movable]
        # Objects that are carried count with their carrier.
        moves = carried.sum(axis=0) * np.where(is_ground, _GROUND_FACTOR, 1.0)
        cuts = _CUT_COST * np.maximum(1.0, NARROW_M / self._sides())
        return np.concatenate([moves, moves, cuts, cuts])

    def _sides(self) -> Float[np.ndarray, " c"]:
        """Lengths of the sides that may be cut, m."""
        return 2 * self._began.half_m[self._movable[self._cut_of], self._cut_axis]

    def sizes(self, x: Float[np.ndarray, " v"]) -> Float[np.ndarray, " v"]:
        """Size of each change, m; both components of a displacement count as one.

        Args:
            x: Values of the unknowns.
        """
        m = len(self._movable)
        moved = np.hypot(x[:m], x[m : 2 * m])
        return np.concatenate([moved, moved, np.abs(x[2 * m :])])

    def applied(self, x: Float[np.ndarray, " v"]) -> Boxes:
        """Give the boxes after some changes; the layout stays as it is.

        Args:
            x: Values of the unknowns.
        """
        m, c = len(self._movable), len(self._cut_of)
        now = self._began.copy()
        now.centre_m[:, :2] += self.carries @ x[: 2 * m].reshape(2, m).T
        if c:
            rows, axis = self._movable[self._cut_of], self._cut_axis
            high, low = x[2 * m : 2 * m + c], x[2 * m + c :]
            # Contradicting demands may ask for more than there is.
            share = np.minimum(1.0, self._spare_m / np.maximum(high + low, _NO_CUT_M))
            high, low = high * share, low * share
            # A cut at one end moves the middle by half of it, and shortens the half extent by half.
            offset = now.axes_of(rows)[np.arange(c), axis] * ((low - high) / 2)[:, None]
            np.add.at(now.centre_m[:, :2], rows, offset)
            np.subtract.at(now.half_m, (rows, axis), (high + low) / 2)
        return now

    def shifts(
        self, rows: Int[np.ndarray, " k"], normal: Float[np.ndarray, "k 2"]
    ) -> Float[np.ndarray, "k v"]:
        """Coefficients of the unknowns in the displacements of objects along normals."""
        m = len(self._movable)
        found = np.zeros((len(rows), self.width))
        carries = self.carries[rows]
        found[:, :m] = carries * normal[:, :1]
        found[:, m : 2 * m] = carries * normal[:, 1:]
        return found

    def add_cuts(
        self,
        demands: Float[np.ndarray, "k v"],
        rows: Int[np.ndarray, " k"],
        normal: Float[np.ndarray, "k 2"],
        sign: float = 1.0,
    ) -> None:
        """Add to demands the room that cuts at the faces of objects towards normals give.

        Args:
            demands: Rows of demands, changed in place.
            rows: Rows of the objects, one for each demand.
            normal: Unit vectors in the plane, one for each.
            sign: -1 if a cut takes room away, as at the host of an object.
        """
        axes = self._began.axes_of(rows)
        for axis in range(2):
            lean = np.einsum("ki,ki->k", axes[:, axis], normal)
            # A slanted face gives its share of a cut.
            # The face that looks towards the normal.
            column = self._column[rows, np.where(lean > 0, axis, axis + 2)]
            k = np.flatnonzero(column >= 0)
            demands[k, column[k]] += sign * np.abs(lean[k])

    def cut_limits(self) -> tuple[Float[np.ndarray, "k v"], Float[np.ndarray, " k"]]:
        """Demands that cuts are not negative, and not too deep; with their bounds."""
        m, c = len(self._movable), len(self._cut_of)
        demands = np.zeros((3 * c, self.width))
        demands[:, 2 * m :] = np.vstack([np.eye(2 * c), -np.hstack([np.eye(c), np.eye(c)])])
        sides = self._sides()
        deepest = np.minimum(np.where(sides < NARROW_M, *DEEPEST_CUT) * sides, self._spare_m)
        return demands, np.concatenate([np.zeros(2 * c), -deepest])
