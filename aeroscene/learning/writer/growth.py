"""A program under construction: coarse tokens depth first, then the fine ones below each of them.

The elements of a program are its tokens and, between them, marks that turn to a coarse token that
is to be furnished. After each element the next token comes at a depth below the scene or the mark;
at depth 0 the part ends. Training and drawing run the same code, so they cannot disagree.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool

from aeroscene.learning.program.program import Program
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.syntax import Syntax, count_objects

# Depths and tokens of a program, at most; at the limit every part ends.
MAX_DEPTH = 24
MAX_TOKENS = 420
N_RECENT = 12
"""Number of latest siblings that the choice of the next token reads."""


@dataclass(slots=True)
class Element:
    """A token, or the mark that turns to one."""

    token: int
    """Place of the token in the program."""
    kind: int
    parent: int
    """Element above; the scene is its own parent."""
    depth: int
    ordinal: int
    is_mark: bool = False
    member: int = 0
    host: int = 0
    shape: int = 0
    children: list[int] = field(default_factory=list)
    """Kinds of its children so far."""
    n_given_children: int = 0
    """Number of children that a mark's coarse token had before."""
    remaining: tuple[int, int] = (0, 0)
    """Coarse and fine objects that are still wished for, after this element."""


@dataclass(frozen=True, slots=True)
class Choice:
    """The next token."""

    kind: int
    member: int = 0
    host: int = 0
    shape: int = 0


class Growth:
    """One program while it grows."""

    def __init__(self, syntax: Syntax, scene_kind: int, wish: Wish) -> None:
        self._syntax = syntax
        self._remaining = [wish.n_coarse, wish.n_fine]
        self.kinds: list[int] = [scene_kind]
        self.parents: list[int] = [0]
        self.choices: list[Choice] = [Choice(scene_kind)]
        self.n_coarse = 1
        self.elements: list[Element] = []
        self.path: list[int] = []
        """Elements from the scene, or from the mark, down to the latest one."""
        self.is_fine = False
        self.is_done = False
        self.has_start = False
        self._of_token: list[int] = []
        self._ahead: list[int] = []
        """Coarse tokens that are still to be furnished, the next one last."""
        self._is_first = syntax.is_as_last.copy()
        """True for kinds that copy the size of the last object of their key. They are masked until
        such an object exists."""
        self._whats: set[int] = set()
        """Keys of which there is an object."""
        self._put(Element(0, scene_kind, 0, 0, 0))
        self.path = [0]

    def _put(self, element: Element) -> int:
        element.remaining = self._remaining[0], self._remaining[1]
        self.elements.append(element)
        if not element.is_mark:
            self._of_token.append(len(self.elements) - 1)
        return len(self.elements) - 1

    @property
    def latest(self) -> Element:
        """The element after which the next token comes."""
        return self.elements[-1]

    def parent_at(self, depth: int) -> int:
        """Return the element whose child a token at a depth from 1 is."""
        return self.path[depth - 1]

    def add(self, depth: int, choice: Choice) -> None:
        """Add a token.

        Args:
            depth: Its depth below the scene or the mark, from 1.
            choice: The token.
        """
        syntax = self._syntax
        above = self.elements[self.path[depth - 1]]
        token = len(self.kinds)
        self.kinds.append(choice.kind)
        self.parents.append(above.token)
        self.choices.append(choice)
        shape = syntax.vocabulary.shapes[choice.shape]
        count = count_objects(syntax.vocabulary.kinds[choice.kind], shape)
        self._remaining[self.is_fine] -= count
        self.has_start |= bool(syntax.is_start[choice.kind])
        self._count_as_last(choice.kind)
        element = Element(
            token,
            choice.kind,
            self.path[depth - 1],
            depth,
            len(above.children),
            member=choice.member,
            host=choice.host,
            shape=choice.shape,
        )
        above.children.append(choice.kind)
        # A token at this depth ends all deeper elements of the path.
        self.path[depth:] = [self._put(element)]
        self.n_coarse += not self.is_fine

    def add_below(self, token: int, choice: Choice) -> None:
        """Add a token below an earlier one, after the end of the program.

        It is no element: nothing is drawn after it, so the network need not read it.

        Args:
            token: Place of the token that bears it.
            choice: The token.
        """
        self.kinds.append(choice.kind)
        self.parents.append(token)
        self.choices.append(choice)
        self.has_start |= bool(self._syntax.is_start[choice.kind])

    def _count_as_last(self, kind: int) -> None:
        """Note a token's key, so that later tokens may copy its size."""
        what = int(self._syntax.what[kind])
        if self._syntax.node[kind] == "unit" and what not in self._whats:
            self._whats.add(what)
            self._is_first &= self._syntax.what != what

    def end(self) -> None:
        """End the part, and turn to the next coarse token that may be furnished.

        Without such a token the program is done.
        """
        if not self.is_fine:
            self.is_fine = True
            bears = self._syntax.bears_fine[self._syntax.class_of[self.kinds]]
            self._ahead = np.flatnonzero(bears).tolist()[::-1]
        if not self._ahead:
            self.is_done = True
            return
        token = self._ahead.pop()
        own = self._of_token[token]
        mark = Element(token, self.kinds[token], own, 0, 0, is_mark=True)
        # The mark continues the coarse token, whose coarse children count as its first children.
        mark.children = list(self.elements[own].children)
        mark.n_given_children = len(mark.children)
        self.path = [self._put(mark)]

    def allowed_depths(self) -> Bool[np.ndarray, " depths"]:
        """Return the depths that the next token may have; 0 ends the part.

        Required children cannot be left out: if an element lacks some, shallower depths are
        forbidden.
        """
        allowed = np.zeros(MAX_DEPTH, dtype=bool)
        # The network may repeat children without end; this limit ends it.
        if len(self.kinds) >= MAX_TOKENS:
            allowed[0] = True
            return allowed
        # From the deepest element upwards: the first that lacks a child
        # forbids everything above it.
        for depth in range(len(self.path), 0, -1):
            if depth >= MAX_DEPTH:
                continue
            allowed[depth] = self.allowed_kinds(depth).any()
            above = self.elements[self.path[depth - 1]]
            if allowed[depth] and self._lacks(above):
                return allowed
        allowed[0] = len(self.kinds) > 1 or not allowed.any()
        return allowed

    def _lacks(self, above: Element) -> bool:
        """True if an element's children are not complete."""
        if len(above.children) < len(self._syntax.required[above.kind]):
            return not self.is_fine
        return bool(self._missing(above).any())

    def _missing(self, above: Element) -> Bool[np.ndarray, " kinds"]:
        """Return the kinds of categories that such a token always has and this one lacks."""
        syntax = self._syntax
        needed = syntax.always[syntax.class_of[above.kind]].copy()
        needed[syntax.category[above.children]] = False
        of_level = syntax.is_coarse != self.is_fine
        return needed[syntax.category] & of_level & ~syntax.is_start & ~self._is_first

    def allowed_kinds(self, depth: int) -> Bool[np.ndarray, " kinds"]:
        """Return the kinds that a token at a depth from 1 may have."""
        syntax = self._syntax
        above = self.elements[self.path[depth - 1]]
        own = syntax.class_of[above.kind]
        cap = syntax.cap[own]
        allowed = (cap > 0) & (syntax.is_coarse != self.is_fine) & ~self._is_first
        if self.has_start:
            allowed &= ~syntax.is_start
        required = syntax.required[above.kind]
        if required:
            # A record that is complete may still bear units.
            if len(above.children) >= len(required):
                return allowed & ~syntax.fits_record
            return allowed & syntax.fits(required[len(above.children)])
        if above.children:
            counts = np.bincount(syntax.class_of[above.children], minlength=len(syntax.most))
            allowed &= counts[syntax.class_of] < cap
        # No more children than any such token had, except for categories that are still missing.
        if len(above.children) >= syntax.most_children[own]:
            missing = self._missing(above)
            allowed &= missing
        return allowed


def replay(
    syntax: Syntax, program: Program, wish: Wish
) -> tuple[Growth, list[tuple[int, Choice | None]]]:
    """Grow a known program, and record the right choice after each of its elements.

    Args:
        syntax: Structure that programs keep.
        program: The known program.
        wish: Wish with which the growth begins.

    Returns:
        The growth at its end; for each element the depth that comes next and, from 1, the choice.
    """
    written = Written(syntax, program, wish)
    growth = written.growth
    said: list[tuple[int, Choice | None]] = [
        written.grow(token) for token in range(1, program.n_coarse)
    ]
    token = program.n_coarse
    said.append((0, None))
    growth.end()
    while not growth.is_done:
        while token < len(program) and written.is_next(token):
            said.append(written.grow(token))
            token += 1
        said.append((0, None))
        growth.end()
    return growth, said


class Written:
    """A known program, which grows token by token."""

    def __init__(self, syntax: Syntax, program: Program, wish: Wish) -> None:
        vocabulary = syntax.vocabulary
        self._program = program
        self._kinds = [vocabulary.nearest(kind) for kind in program.kinds]
        self._shapes = [vocabulary.nearest_shape(shape) for shape in program.shapes]
        self._parents = program.parent.tolist()
        self.growth = Growth(syntax, self._kinds[0], wish)
        self.place_of = {0: 0}
        """Place in the growth of each token of the program that has grown."""

    def grow(self, token: int) -> tuple[int, Choice]:
        """Add a token, and return its depth and its choice."""
        growth, above = self.growth, self.place_of[self._parents[token]]
        places = (growth.elements[element].token for element in growth.path)
        # The parent is always on the path, because tokens come depth first.
        depth = 1 + next(depth for depth, place in enumerate(places) if place == above)
        choice = Choice(
            self._kinds[token],
            int(self._program.member[token]),
            int(self._program.host[token]),
            self._shapes[token],
        )
        self.place_of[token] = len(growth.kinds)
        growth.add(depth, choice)
        return depth, choice

    def is_next(self, token: int) -> bool:
        """True if a token comes below the element that is being furnished."""
        growth, above = self.growth, self.place_of.get(self._parents[token])
        return any(growth.elements[element].token == above for element in growth.path)
