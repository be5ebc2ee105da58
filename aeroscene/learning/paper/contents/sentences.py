"""Contents of a layout as a sequence of tokens.

    half extent east, half extent north, coarse objects..., END, fine objects..., END

The token of an object is its category and its quarter turn. With regions there is one list of fine
objects for each coarse one whose category holds any, in their order, and a last one for the site.

    numbers      token
    0 to 4C - 1  an object: 4 (c - 1) + quarter turn
    4C           END of a list
    4C + 1 ...   bins of a half extent

Bins are even in the logarithm, because layouts range from single rooms to large sites.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from aeroscene.learning.paper.channels import FlatStatistics, frames_of, measured_channels
from aeroscene.learning.paper.layouts import NO_REGION, FlatLayout
from aeroscene.scene.catalogue import CATALOGUE, COARSE_COUNT

N_CATEGORIES = len(CATALOGUE)
END = 4 * N_CATEGORIES
N_BINS = 48
_FIRST_BIN = END + 1
N_TOKENS = _FIRST_BIN + N_BINS
# Half extents of the first bin's lower and the last bin's upper edge.
_HALVES_M = (0.5, 250.0)
SITE = N_CATEGORIES + 1
"""Place of the list of the site's own fine objects; other lists have the category of their region
as place."""
COARSE_LIST = 0
"""Place of the list of coarse objects."""


@dataclass(frozen=True, eq=False)
class Contents:
    """Contents of a layout: extent, categories, quarter turns and regions."""

    half_m: tuple[float, float]
    """Half extents east and north."""
    category: Int[np.ndarray, " n"]
    """Numbers of the catalogue, from 1; coarse objects come first."""
    turn: Int[np.ndarray, " n"]
    region: Int[np.ndarray, " n"]
    """Row of the coarse object that a fine one belongs to, or `NO_REGION`."""
    n_coarse: int


@dataclass(frozen=True, eq=False)
class Sentence:
    """Contents as tokens, and the place of the list that each token is in."""

    token: Int[np.ndarray, " n"]
    place: Int[np.ndarray, " n"]


def allowed(step: int, place: int) -> Bool[np.ndarray, " tokens"]:
    """Return which tokens may stand at a step within a list.

    Args:
        step: Number of the token in its sentence; the first two are half extents.
        place: Place of the list: `COARSE_LIST`, `SITE` or a category.
    """
    result = np.zeros(N_TOKENS, dtype=bool)
    if step < 2:
        result[_FIRST_BIN:] = True
    elif place == COARSE_LIST:
        result[: 4 * COARSE_COUNT] = True
        result[END] = True
    else:
        result[4 * COARSE_COUNT : END + 1] = True
    return result


def bin_of(half_m: float) -> int:
    """Return the token of a half extent in metres; values out of range take the outermost bin."""
    low, high = np.log(_HALVES_M)
    share = (np.log(half_m) - low) / (high - low)
    return _FIRST_BIN + int(np.clip(share * N_BINS, 0, N_BINS - 1))


def half_of(token: int, share: float) -> float:
    """Return the half extent at a share, 0 to 1, of the bin of a token, m."""
    low, high = np.log(_HALVES_M)
    return float(np.exp(low + (high - low) * (token - _FIRST_BIN + share) / N_BINS))


def places_of(coarse: Sequence[int], statistics: FlatStatistics) -> list[int]:
    """Return the rows of the coarse objects with a list of their own, and `NO_REGION` at the end.

    Args:
        coarse: Categories of the coarse objects.
        statistics: Statistics that say which categories hold fine objects.
    """
    # A category that never holds anything needs no list, which would be only END.
    holders = [
        row for row, c in enumerate(coarse) if statistics.has_regions and statistics.holds[c]
    ]
    return [*holders, NO_REGION]


def sentence_of(layout: FlatLayout, statistics: FlatStatistics) -> Sentence:
    """Write the contents of a layout as tokens.

    Args:
        layout: The layout, coarse objects first.
        statistics: Statistics that say which categories have a list of their own.
    """
    _, turn = measured_channels(layout, frames_of(layout, statistics))
    item = 4 * (layout.category - 1) + turn
    n = layout.n_coarse
    tokens = [bin_of(half) for half in layout.half_m]
    places = [COARSE_LIST, COARSE_LIST]
    lists = [(COARSE_LIST, item[:n])]
    for row in places_of(layout.category[:n].tolist(), statistics):
        place = SITE if row == NO_REGION else int(layout.category[row])
        lists.append((place, item[n:][layout.region[n:] == row]))
    for place, items in lists:
        tokens += [*items.tolist(), END]
        places += [place] * (len(items) + 1)
    return Sentence(np.array(tokens), np.array(places))


class Reading:
    """Reads contents token by token."""

    def __init__(self, statistics: FlatStatistics) -> None:
        self._statistics = statistics
        self._half_m: list[float] = []
        self._items: list[int] = []
        self._region: list[int] = []
        self._n_coarse = 0
        self._lists: list[int] | None = None
        self.step = 0

    @property
    def place(self) -> int:
        """Place of the list that the next token is in."""
        if self._lists is None:
            return COARSE_LIST
        row = self._lists[0]
        return SITE if row == NO_REGION else 1 + self._items[row] // 4

    @property
    def is_done(self) -> bool:
        """True once every list is at its end."""
        return self._lists is not None and not self._lists

    def take(self, token: int, share: float) -> None:
        """Read a token; `share` is the place of a half extent in its bin, 0 to 1."""
        if self.step < 2:
            self._half_m.append(half_of(token, share))
        elif token != END:
            self._items.append(token)
            self._region.append(NO_REGION if self._lists is None else self._lists[0])
        elif self._lists is None:
            self._n_coarse = len(self._items)
            # The coarse list has ended: only now is it known which lists of fine objects follow.
            self._lists = places_of([1 + item // 4 for item in self._items], self._statistics)
        else:
            del self._lists[0]
        self.step += 1

    @property
    def contents(self) -> Contents:
        """The contents that were read so far."""
        items = np.array(self._items, dtype=int)
        n_coarse = len(items) if self._lists is None else self._n_coarse
        east, north = self._half_m
        return Contents(
            (east, north), 1 + items // 4, items % 4, np.array(self._region, dtype=int), n_coarse
        )
