"""Drawing of programs from the writer, within its syntax.

The network proposes, and the syntax forbids tokens that no program has: their probability is 0
before the draw. Every drawn program can therefore be decoded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.program.kinds import theme_of
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.bucket import bucket
from aeroscene.learning.writer.config import WriterError
from aeroscene.learning.writer.furnishing import Furnishing
from aeroscene.learning.writer.growth import Choice, Growth
from aeroscene.learning.writer.lesson import recent_of, seen_of, wish_numbers
from aeroscene.learning.writer.stepwise import StepwiseWriter
from aeroscene.learning.writer.syntax import Syntax


def draw_program(
    writer: StepwiseWriter,
    syntax: Syntax,
    wish: Wish,
    rng: np.random.Generator,
    given: Furnishing | None = None,
    theme: str | None = None,
) -> Growth:
    """Draw a program for a wish.

    Args:
        writer: The network.
        syntax: Structure that the program keeps.
        wish: Domain, and approximate numbers of objects.
        rng: Source of the draw.
        given: A given part, which is furnished; None lets the writer draw everything.
        theme: Theme of the place; None draws one.

    Raises:
        WriterError: If it never saw a scene of the domain or of the theme.
    """
    draw = _Draw(writer, syntax, wish, rng)
    if given is None:
        growth = Growth(syntax, _scene_kind(syntax, wish, theme, rng), wish)
    else:
        growth = given.growth
        # The writer reads the coarse tokens that are given, and turns to the
        # first that bears fine ones.
        draw.read(growth)
        growth.end()
    while not growth.is_done:
        draw.step(growth, given)
    draw.add_start(growth)
    return growth


def _scene_kind(syntax: Syntax, wish: Wish, theme: str | None, rng: np.random.Generator) -> int:
    """Return the root of a program: of the theme asked for, or drawn as the corpus has it."""
    vocabulary = syntax.vocabulary
    roots = [i for i, kind in enumerate(vocabulary.kinds) if kind.node == "scene"]
    fitting = [i for i in roots if vocabulary.kinds[i].domain == wish.domain]
    if not fitting:
        known = sorted({vocabulary.kinds[i].domain for i in roots})
        raise WriterError(
            f"domain is {wish.domain!r}, which the model never saw; valid: {', '.join(known)}"
        )
    if theme is not None:
        themes = {theme_of(vocabulary.kinds[i]): i for i in fitting}
        if theme not in themes:
            valid = (
                ", ".join(sorted(filter(None, themes))) or "none, since the model knows no themes"
            )
            raise WriterError(f"theme is {theme!r} for domain {wish.domain!r}; valid: {valid}")
        return themes[theme]
    counts = np.array([vocabulary.counts[i] for i in fitting], dtype=float)
    return fitting[int(rng.choice(len(fitting), p=counts / counts.sum()))]


class _Next(NamedTuple):
    """The token after an element; depth 0 ends the part."""

    depth: int
    kind: int | None
    local: Float[np.ndarray, " l"] | None
    """Features on which the network's further choices depend."""


_END = _Next(0, None, None)


class _Pad(NamedTuple):
    """The place where a start pad was likeliest."""

    chance: float
    above: int
    """Token that would bear it."""
    kinds: Int[np.ndarray, " k"]
    """Kinds that it may have."""
    logits: Float[np.ndarray, " k"]
    local: Float[np.ndarray, " l"]


class _Draw:
    """A program while it is drawn, and the network's features of it."""

    def __init__(
        self, writer: StepwiseWriter, syntax: Syntax, wish: Wish, rng: np.random.Generator
    ) -> None:
        self._writer, self._syntax, self._rng = writer, syntax, rng
        self._reading = writer.begin(wish_numbers(wish))
        self.known: list[Float[np.ndarray, " w"]] = []
        """Features after each element."""
        self._kin: list[Bool[np.ndarray, " t"]] = []
        self._is_fine = False
        self._pad: _Pad | None = None

    def step(self, growth: Growth, given: Furnishing | None = None) -> None:
        """Draw the token after the latest element.

        Args:
            growth: The program so far; it grows.
            given: Given tokens, which come back in their turn.
        """
        is_closed = given is not None and given.is_closed()
        depth, kind, local = _END if is_closed else self._next(growth)
        if depth < 2 and given is not None and given.comes_first(kind):
            given.put_back()
        elif kind is None or local is None:
            growth.end()
        else:
            growth.add(depth, self._choice(kind, local))

    def _next(self, growth: Growth) -> _Next:
        """Draw depth and kind of the token after the latest element."""
        self.read(growth)
        known = self.known[-1]
        depth = self._choose(self._writer.depth(known), growth.allowed_depths())
        if depth == 0:
            return _END
        above = growth.parent_at(depth)
        recent, n_siblings = recent_of(growth, above)
        local = self._writer.local(
            known,
            self.known[above],
            growth.elements[above].kind,
            recent,
            int(bucket(np.array([n_siblings]))[0]),
            depth,
        )
        allowed = growth.allowed_kinds(depth)
        # If the syntax forbids everything, everything is allowed: the draw must go on.
        kinds = np.flatnonzero(allowed if allowed.any() else ~allowed)
        logits = self._writer.kind_logits(local, kinds)
        self._watch_for_start(growth.elements[above].token, kinds, logits, local)
        return _Next(depth, int(kinds[self._choose(logits)]), local)

    def _watch_for_start(
        self,
        above: int,
        kinds: Int[np.ndarray, " k"],
        logits: Float[np.ndarray, " k"],
        local: Float[np.ndarray, " l"],
    ) -> None:
        """Remember the place where a start pad was likeliest so far."""
        may_be = self._syntax.is_start[kinds]
        if not may_be.any():
            return
        weight = np.exp(logits - logits.max())
        chance = float(weight[may_be].sum() / weight.sum())
        if self._pad is None or chance > self._pad.chance:
            self._pad = _Pad(chance, above, kinds[may_be], logits[may_be], local)

    def add_start(self, growth: Growth) -> None:
        """Add the start pad where it was likeliest, if every place left it out.

        It is rare at each single place, so a third of all programs would have none.
        """
        if growth.has_start or self._pad is None:
            return
        pad = self._pad
        kind = int(pad.kinds[self._choose(pad.logits)])
        growth.add_below(pad.above, self._choice(kind, pad.local))

    def _choice(self, kind: int, local: Float[np.ndarray, " l"]) -> Choice:
        """Draw member, host and array of a token of a kind."""
        logits = self._writer.rest_logits(local, kind)
        allowed = (None, None, self._syntax.shapes(kind))
        member, host, shape = map(self._choose, logits, allowed)
        is_group = self._syntax.vocabulary.kinds[kind].is_group
        return Choice(kind, member, host, shape if is_group else 0)

    def read(self, growth: Growth) -> None:
        """Read the elements that are new."""
        for index in range(len(self.known), len(growth.elements)):
            element = growth.elements[index]
            # The lesson has the same column: once a mark has come, the part is fine.
            self._is_fine |= element.is_mark
            seen = np.array(seen_of(growth, element))
            seen[11] = self._is_fine
            seen[8:11] = bucket(seen[8:11])
            self.known.append(self._reading.read(seen.tolist(), self._kin_of(growth)))

    def _kin_of(self, growth: Growth) -> Bool[np.ndarray, " t"]:
        """Mark the elements above the next one, itself, and its earlier siblings."""
        index = len(self.known)
        parent = growth.elements[index].parent
        kin = np.zeros(index + 1, dtype=bool)
        if index:
            above = self._kin[parent]
            kin[: len(above)] = above
            own = (each.parent == parent for each in growth.elements[1:index])
            kin[1:index] |= np.fromiter(own, dtype=bool, count=index - 1)
        kin[index] = True
        self._kin.append(kin)
        return kin

    def _choose(
        self,
        logits: Float[np.ndarray, " choices"],
        allowed: Bool[np.ndarray, " choices"] | None = None,
    ) -> int:
        known = logits.astype(np.float64)
        if allowed is not None and allowed.any():
            known = np.where(allowed, known, -np.inf)
        # Relative to the likeliest, so that the threshold is a share of it.
        weight = np.exp(known - known.max())
        total = np.where(weight < self._writer.cfg.least_share, 0.0, weight).cumsum()
        # The uniform number is above 0 and up to 1, so that the first sum to reach it is never that
        # of a choice with probability 0.
        return int((total < (1.0 - self._rng.random()) * total[-1]).sum())
