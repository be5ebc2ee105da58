"""A program of which a part is given: its coarse tokens, and among its fine ones those that stay.

What is given below a coarse token comes back where it would stand among what is drawn: the larger
first, chairs last, as in training. So the writer knows of it when it draws what follows.
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
            syntax: What programs keep to.
            program: What is given.
            wish: Numbers of objects, those that are given among them.
            is_open: Coarse tokens below which more may come; None for all.
            has_start: Whether no start pad may come.
        """
        self._program, self._is_open = program, is_open
        self._children = program.children()
        self._written = Written(syntax, program, wish)
        for token in range(1, program.n_coarse):
            self._written.grow(token)
        self._kinds = syntax.vocabulary.kinds
        self._mark = -1
        self._waiting: list[int] = []
        self.growth.has_start |= has_start

    @property
    def growth(self) -> Growth:
        """The program as it grows."""
        return self._written.growth

    @property
    def place_of(self) -> dict[int, int]:
        """For each given token its place in the growth; below what never bears anything none."""
        return self._written.place_of

    def is_closed(self) -> bool:
        """Whether nothing but what is given may come below the coarse token that is furnished."""
        self._turn_to_mark()
        return self._is_open is not None and self._mark not in self._is_open

    def comes_first(self, kind: int | None) -> bool:
        """Whether given tokens come before one of a kind that is drawn; all before the end."""
        self._turn_to_mark()
        if not self._waiting:
            return False
        if kind is None:
            return True
        own = self._program.kinds[self._waiting[-1]].category
        return _usual_m2(own) >= _usual_m2(self._kinds[kind].category)

    def put_back(self) -> None:
        """Add the next given token of those that wait, with all that it bears."""
        self._grow(self._waiting.pop())

    def _turn_to_mark(self) -> None:
        """Let what is given below the coarse token that is furnished wait, the first one last."""
        growth = self.growth
        mark = growth.elements[growth.path[0]].token
        if growth.is_fine and mark != self._mark:
            self._mark = mark
            own = self._children[mark]
            self._waiting = [token for token in own if token >= self._program.n_coarse][::-1]

    def _grow(self, token: int) -> None:
        self._written.grow(token)
        for child in self._children[token]:
            self._grow(child)


def _usual_m2(category: str) -> float:
    """Area that things of a category take up; none of what comes last."""
    found = by_name()[category]
    if found.name in SEATS:
        return 0.0
    return sum(found.length_m) * sum(found.width_m) / 4
