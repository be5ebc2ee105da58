"""Fitting: from rectangles that do not overlap to the tree that divides their hull as they do.

All edges of the rectangles form a grid, and each grid cell has an owner. A line that crosses no
owner is a cut. The window is divided by all its cuts at once, and its parts are fitted in turn.
Windows without any cut are pinwheels. Anything else becomes a grid whose cells share merge numbers,
so that every layout has a tree.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Int

from aeroscene.partition.frames import Bounds, hull_of
from aeroscene.partition.pinwheel import find_pinwheel
from aeroscene.partition.tree import (
    VOID,
    Axis,
    Cross,
    Leaf,
    Node,
    Overlay,
    Part,
    PartitionError,
    Pinwheel,
    Slice,
    children,
    parts_of,
    walk,
    with_children,
)

SAME_M = 0.004
"""Edges that are this near to each other lie on one line."""
# Strips whose widths differ by less share one width, and -1 owns cells that no piece covers.
_SAME_WIDTH_M = 0.002
_VOID = -1

_Owners = Int[np.ndarray, "columns rows"]
_Window = tuple[int, int, int, int]
"""First column and the one behind the last, then the same of rows."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A rectangle to fit, along the axes of the frame."""

    bounds: Bounds
    node: Leaf | Overlay
    key: int
    """Number above 0; pieces of one key become leaves of one merge number."""


@dataclass(slots=True)
class Widths:
    """Widths in m that the strips of a site share."""

    kinds: frozenset[str] = frozenset()
    """Kinds of leaves that are strips if they are longer than wide."""
    found_m: list[float] = field(default_factory=list)
    """Widths found so far."""

    def shared(self, width_m: float) -> float:
        """Return a width that was found before if there is a similar one, else this one.

        Widths that are equal up to rounding become one, so that a sequence names few of them.
        """
        for known in self.found_m:
            if abs(known - width_m) <= _SAME_WIDTH_M:
                return known
        self.found_m.append(width_m)
        return width_m


def fit(pieces: Sequence[Piece], widths: Widths | None = None, hull: Bounds | None = None) -> Node:
    """Fit a tree to pieces over their hull, or over a larger one.

    Leaves keep the keys of their pieces in `merge`, see `number_merges`.

    Args:
        pieces: They may leave gaps, which become void leaves.
        widths: Kinds that are strips; their widths are added to it.
        hull: Frame of the tree; the pieces' own hull by default.

    Raises:
        PartitionError: If pieces overlap by more than `SAME_M` or one is thinner than that.
    """
    return _Fitter(pieces, widths or Widths(), hull or hull_of(p.bounds for p in pieces)).whole()


def number_merges(node: Node) -> Node:
    """Number the keys of leaves from 1 in order.

    A key with one leaf alone becomes 0. Equal layouts therefore have equal trees, whatever the ids
    of their objects.
    """
    found = [n.merge for n in walk(node) if isinstance(n, Leaf) and n.merge]
    counts = Counter(found)
    several = [key for key in dict.fromkeys(found) if counts[key] > 1]
    numbers = {key: number for number, key in enumerate(several, 1)}
    return _renumbered(node, numbers)


def _renumbered(node: Node, numbers: dict[int, int]) -> Node:
    if isinstance(node, Leaf):
        return replace(node, merge=numbers.get(node.merge, 0))
    return with_children(node, tuple(_renumbered(child, numbers) for child in children(node)))


class _Fitter:
    """Pieces as owners of the grid cells between all their edges."""

    def __init__(self, pieces: Sequence[Piece], widths: Widths, hull: Bounds) -> None:
        self.pieces, self.widths = pieces, widths
        boxes = [piece.bounds for piece in pieces] + [hull]
        self.x = _lines([b[i] for b in boxes for i in (0, 2)])
        self.y = _lines([b[i] for b in boxes for i in (1, 3)])
        self.owners: _Owners = np.full((len(self.x) - 1, len(self.y) - 1), _VOID)
        self.ranges = [self._range(piece) for piece in pieces]
        for index, (i0, i1, j0, j1) in enumerate(self.ranges):
            if (self.owners[i0:i1, j0:j1] != _VOID).any():
                raise PartitionError(
                    f"piece {pieces[index].key} overlaps another; valid: none does"
                )
            self.owners[i0:i1, j0:j1] = index

    def _range(self, piece: Piece) -> _Window:
        x0, y0, x1, y1 = piece.bounds
        i0, i1 = (int(np.abs(self.x - x).argmin()) for x in (x0, x1))
        j0, j1 = (int(np.abs(self.y - y).argmin()) for y in (y0, y1))
        if i0 == i1 or j0 == j1:
            raise PartitionError(f"piece {piece.key} is thinner than {SAME_M} m")
        return (i0, i1, j0, j1)

    def whole(self) -> Node:
        return self.node((0, len(self.x) - 1, 0, len(self.y) - 1))

    def node(self, window: _Window) -> Node:
        owners = self._owners(window)
        if (owners == owners[0, 0]).all():
            return self._leaf(int(owners[0, 0]), window)
        cuts: dict[Axis, list[int]] = {"x": full_cuts(owners), "y": full_cuts(owners.T)}
        # Rows first, with columns that pass through them: most streets run along their site's x.
        for axis in ("y", "x"):
            shared = self._shared_cuts(window, axis, cuts[axis])
            if shared:
                across = {axis: cuts[axis], ("x" if axis == "y" else "y"): shared}
                return self._cross(window, across["x"], across["y"])
        # The axis with more cuts gives the flatter tree.
        axis: Axis = "x" if len(cuts["x"]) > len(cuts["y"]) else "y"
        if cuts[axis]:
            return self._slice(window, axis, cuts[axis])
        pinwheel = find_pinwheel(can_cut(owners), can_cut(owners.T).T)
        if pinwheel:
            return self._pinwheel(window, *pinwheel)
        # Nothing fits: a grid of all lines, whose cells are joined by merge numbers.
        lines = [np.flatnonzero((o[1:] != o[:-1]).any(axis=1)) + 1 for o in (owners, owners.T)]
        return self._cross(window, lines[0].tolist(), lines[1].tolist(), is_fallback=True)

    def _owners(self, window: _Window) -> _Owners:
        i0, i1, j0, j1 = window
        return self.owners[i0:i1, j0:j1]

    def _leaf(self, owner: int, window: _Window) -> Node:
        if owner == _VOID:
            return Leaf(VOID)
        piece = self.pieces[owner]
        if isinstance(piece.node, Leaf):
            return replace(piece.node, merge=piece.key)
        # A cover with others on it must stay one cell, because they have places in its frame.
        if self.ranges[owner] != window:
            raise PartitionError(f"piece {piece.key} carries others; valid: one cell for it")
        return replace(piece.node, base=replace(piece.node.base, merge=piece.key))

    def _shared_cuts(self, window: _Window, axis: Axis, cuts: list[int]) -> list[int]:
        """Return cuts through all bands between the cuts of an axis.

        Bands of a single leaf are ignored: a road across a site may be divided. A cover that
        carries others may not, so there are no shared cuts then.
        """
        owners = self._owners(window) if axis == "x" else self._owners(window).T
        shared: list[set[int]] = []
        for low, high in pairwise([0, *cuts, len(owners)]):
            band = owners[low:high]
            if (band != band[0, 0]).any():
                shared.append(set(full_cuts(band.T)))
            elif band[0, 0] != _VOID and isinstance(self.pieces[band[0, 0]].node, Overlay):
                return []
        return sorted(set.intersection(*shared)) if len(shared) > 1 else []

    def _slice(self, window: _Window, axis: Axis, cuts: list[int]) -> Slice:
        i0, i1, j0, j1 = window
        windows = (
            [(i0 + a, i0 + b, j0, j1) for a, b in pairwise([0, *cuts, i1 - i0])]
            if axis == "x"
            else [(i0, i1, j0 + a, j0 + b) for a, b in pairwise([0, *cuts, j1 - j0])]
        )
        return Slice(axis, self._parts(windows, axis), tuple(map(self.node, windows)))

    def _cross(
        self, window: _Window, columns: list[int], rows: list[int], *, is_fallback: bool = False
    ) -> Cross:
        i0, i1, j0, j1 = window
        x = list(pairwise([i0, *(i0 + i for i in columns), i1]))
        y = list(pairwise([j0, *(j0 + j for j in rows), j1]))
        return Cross(
            self._parts([(*pair, j0, j1) for pair in x], "x"),
            self._parts([(i0, i1, *pair) for pair in y], "y"),
            tuple(self.node((*column, *row)) for row in y for column in x),
            is_fallback=is_fallback,
        )

    def _pinwheel(self, window: _Window, is_mirrored: bool, cuts: _Window) -> Pinwheel:
        i0, i1, j0, j1 = window
        west, east, south, north = i0 + cuts[0], i0 + cuts[1], j0 + cuts[2], j0 + cuts[3]
        if is_mirrored:
            arms = ((west, i1, j0, south), (east, i1, south, j1), (i0, east, north, j1))
            last = (i0, west, j0, north)
        else:
            arms = ((i0, east, j0, south), (east, i1, j0, north), (west, i1, north, j1))
            last = (i0, west, south, j1)
        return Pinwheel(
            is_mirrored,
            (
                _share(self.x, i0, west, i1),
                _share(self.x, i0, east, i1),
                _share(self.y, j0, south, j1),
                _share(self.y, j0, north, j1),
            ),
            (self.node(arms[0]), self.node(arms[1]), self.node(arms[2]), self.node(last)),
            self.node((west, east, south, north)),
        )

    def _parts(self, windows: list[_Window], axis: Axis) -> tuple[Part, ...]:
        lines, at = (self.x, 0) if axis == "x" else (self.y, 2)
        lengths = [float(lines[w[at + 1]] - lines[w[at]]) for w in windows]
        strips = [self._is_strip(window, axis) for window in windows]
        fixed = [self.widths.shared(n) if s else n for n, s in zip(lengths, strips, strict=True)]
        return parts_of(fixed, strips)

    def _is_strip(self, window: _Window, axis: Axis) -> bool:
        """True if a strip of a kind with a width in m runs through, as wide as the window."""
        at, across = (0, 2) if axis == "x" else (2, 0)
        for owner in np.unique(self._owners(window)):
            if (
                owner == _VOID
                or getattr(self.pieces[owner].node, "kind", "") not in self.widths.kinds
            ):
                continue
            x0, y0, x1, y1 = self.pieces[owner].bounds
            sides = {0: x1 - x0, 2: y1 - y0}
            is_as_wide = self.ranges[owner][at : at + 2] == window[at : at + 2]
            if is_as_wide and sides[across] >= sides[at]:
                return True
        return False


def can_cut(owners: _Owners) -> Bool[np.ndarray, "cuts rows"]:
    """True if a line before each column but the first crosses nothing, row by row."""
    return (owners[1:] != owners[:-1]) | (owners[1:] == _VOID)


def full_cuts(owners: _Owners) -> list[int]:
    """Return the columns before which a line can cut from side to side.

    It crosses nothing in any row, and it separates something in at least one.
    """
    is_cut = can_cut(owners).all(axis=1) & (owners[1:] != owners[:-1]).any(axis=1)
    return (np.flatnonzero(is_cut) + 1).tolist()


def _share(lines: np.ndarray, low: int, at: int, high: int) -> float:
    """Place of a line between two others, 0 to 1."""
    return float((lines[at] - lines[low]) / (lines[high] - lines[low]))


def _lines(values: Sequence[float]) -> np.ndarray:
    """Return coordinates, with those that belong to one line averaged."""
    ordered = np.sort(np.asarray(values))
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > SAME_M) + 1)
    return np.array([group.mean() for group in groups])
