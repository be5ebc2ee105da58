"""A program with a given part: its coarse tokens, and those of its fine tokens that stay.

Given tokens below a coarse token come back where they would stand among drawn ones: the larger
first, chairs last, as in training. The writer therefore knows them when it draws the tokens that
follow.
"""

from __future__ import annotations

from collections.abc import Collection

from aeroscene.learning.program.program import Program
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.growth import Growth, Written
from aeroscene.learning.writer.syntax import Syntax
from aeroscene.scene.catalogue import SEATS, by_name


class Furnishing:
    """A growth with a given part."""

    def __init__(
        self,
        syntax: Syntax,
        program: Program,
        wish: Wish,
        is_open: Collection[int] | None = None,
        *,
        has_start: bool = False,
    ) -> None:
        """Begin with the coarse tokens.

        Args:
            syntax: Structure that programs keep.
            program: The given tokens.
            wish: Numbers of objects, given ones included.
            is_open: Coarse tokens below which more may come; None opens all.
            has_start: True allows no further start pad.
        """
        self._program, self._is_open = program, is_open
        self._children = program.children()
        self._written = Written(syntax, program, wish)
        for token in range(1, program.n_coarse):
            self._written.grow(token)
        self._kinds = syntax.vocabulary.kinds
        self._mark = -1
        self._waiting: list[int] = []
        # A region that is redone keeps the pad that the scene has elsewhere.
        self.growth.has_start |= has_start

    @property
    def growth(self) -> Growth:
        """The program as it grows."""
        return self._written.growth

    @property
    def place_of(self) -> dict[int, int]:
        """Place in the growth of each given token that is in it.

        Tokens below a kind that never bears any are not in it.
        """
        return self._written.place_of

    def is_closed(self) -> bool:
        """True if the coarse token that is being furnished may get given tokens only."""
        self._turn_to_mark()
        return self._is_open is not None and self._mark not in self._is_open

    def comes_first(self, kind: int | None) -> bool:
        """True if a given token comes before a token of a kind that is drawn.

        Args:
            kind: The drawn kind; None for the end, before which all given tokens come.
        """
        self._turn_to_mark()
        if not self._waiting:
            return False
        if kind is None:
            return True
        own = self._program.kinds[self._waiting[-1]].category
        return _usual_m2(own) >= _usual_m2(self._kinds[kind].category)

    def put_back(self) -> None:
        """Add the next waiting token, with everything that it bears."""
        self._grow(self._waiting.pop())

    def _turn_to_mark(self) -> None:
        """Queue the given tokens of the coarse token that is being furnished."""
        growth = self.growth
        mark = growth.elements[growth.path[0]].token
        if growth.is_fine and mark != self._mark:
            self._mark = mark
            own = self._children[mark]
            # Reversed, because the next one is taken from the end.
            self._waiting = [token for token in own if token >= self._program.n_coarse][::-1]

    def _grow(self, token: int) -> None:
        self._written.grow(token)
        for child in self._children[token]:
            self._grow(child)


def _usual_m2(category: str) -> float:
    """Usual area of a category, in which order units are drawn; 0 for seats, which come last."""
    found = by_name()[category]
    if found.name in SEATS:
        return 0.0
    return sum(found.length_m) * sum(found.width_m) / 4
