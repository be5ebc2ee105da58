"""What a program is: a tree of tokens, coarse ones first, in arrays."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from aeroscene.learning.program.clearances import NO_CLEARANCES, Clearances
from aeroscene.learning.program.companions import ANY_COMPANIONS, Companions
from aeroscene.learning.program.kinds import Kind, UnitKind
from aeroscene.relations.relation import Array
from aeroscene.scene import AttributeValue

N_CHANNELS = 19
U, V, COS, SIN, RISE = range(5)
SIZE, PITCH, OPENING, TILT = slice(5, 8), slice(8, 10), slice(10, 17), slice(17, 19)
"""Channels of a unit; a record has its share first and its numbers after it."""
REFERENCED = (RISE, 5, 6, 7)
"""Channels that may count from several things, see `aeroscene.learning.program.references`."""
N_MEMBERS, N_HOSTS = 16, 32
"""Numbers of members and ranks of hosts that networks tell apart; greater ones read as the last."""

Looks = dict[str, AttributeValue]


class ProgramError(ValueError):
    """A scene that has no program; one line that names object and reason."""


class Shape(NamedTuple):
    """The discrete part of a group's array."""

    rows: int = 1
    columns: int = 1
    holes: tuple[int, ...] = ()
    turned: tuple[int, ...] = ()

    @staticmethod
    def of(array: Array | None) -> Shape:
        """That of an array; of one object a single cell."""
        if array is None:
            return Shape()
        return Shape(array.rows, array.columns, array.holes, array.turned)

    def array(self, pitch_m: tuple[float, float] = (0.0, 0.0)) -> Array:
        """The array of such a group with some pitch."""
        return Array(
            rows=self.rows,
            columns=self.columns,
            pitch_m=pitch_m,
            holes=self.holes,
            turned=self.turned,
        )


@dataclass(slots=True, eq=False)
class Node:
    """A token in a tree, as it is built."""

    kind: Kind
    channels: Float[np.ndarray, " 19"] = field(default_factory=lambda: np.full(N_CHANNELS, np.nan))
    member: int = 0
    host: int = 0
    shape: Shape = field(default_factory=Shape)
    choices: Float[np.ndarray, "4 4"] | None = None
    """For each of `REFERENCED` its value from each reference."""
    looks: list[Looks] = field(default_factory=list)
    beside: str = ""
    """Of a unit what its host is, see `aeroscene.learning.program.companions`."""
    ids: list[int] = field(default_factory=list)
    """Objects that the token stands for."""
    children: list[Node] = field(default_factory=list)

    def add(self, child: Node) -> Node:
        """Let a node be the last child."""
        self.children.append(child)
        return child


@dataclass(frozen=True, eq=False, kw_only=True)
class Program:
    """A scene as tokens: the scene's own first, coarse ones depth first, then the fine ones."""

    kinds: tuple[Kind, ...]
    parent: Int[np.ndarray, " n"]
    """Places of the parents; the scene is its own."""
    member: Int[np.ndarray, " n"]
    """Which of the objects of the parent's token bears the token."""
    host: Int[np.ndarray, " n"]
    """Rank of the host; of a border how many leaves on the room beyond it is."""
    shapes: tuple[Shape, ...]
    channels: Float[np.ndarray, "n channels"]
    """NaN where a token has none."""
    references: Int[np.ndarray, "n 4"]
    """From what each of `REFERENCED` counts."""
    n_coarse: int
    looks: tuple[tuple[Looks, ...], ...] = ()
    """For each token of its objects in turn; empty until drawn."""
    clearances: Clearances = NO_CLEARANCES
    """What units keep where they look for room; nothing of a program that was read off a scene."""
    companions: Companions = ANY_COMPANIONS
    """What units may stand beside; anything in a program that was read off a scene."""

    def __len__(self) -> int:
        return len(self.kinds)

    def unit(self, place: int) -> UnitKind:
        """The kind of a token that is a unit."""
        kind = self.kinds[place]
        assert isinstance(kind, UnitKind)
        return kind

    def with_channels(self, channels: Float[np.ndarray, "n channels"]) -> Program:
        """The same tokens with other numbers."""
        return replace(self, channels=channels)

    def children(self) -> list[list[int]]:
        """Places of the children of each token, in order."""
        found: list[list[int]] = [[] for _ in self.kinds]
        for place, parent in enumerate(self.parent.tolist()):
            if place:
                found[parent].append(place)
        return found


def in_order(root: Node) -> tuple[list[Node], list[int], int]:
    """Nodes in a program's order, the places of their parents, and how many are coarse."""
    coarse: list[tuple[Node, Node]] = []
    _descend(root, root, coarse, is_coarse=True)
    fine: list[tuple[Node, Node]] = []
    for node, _ in coarse:
        for child in node.children:
            if not child.kind.is_coarse:
                _descend(child, node, fine, is_coarse=False)
    pairs = coarse + fine
    place = {id(node): index for index, (node, _) in enumerate(pairs)}
    return [node for node, _ in pairs], [place[id(above)] for _, above in pairs], len(coarse)


def _descend(node: Node, above: Node, found: list[tuple[Node, Node]], *, is_coarse: bool) -> None:
    found.append((node, above))
    for child in node.children:
        if not is_coarse or child.kind.is_coarse:
            _descend(child, node, found, is_coarse=is_coarse)


def to_program(root: Node) -> Program:
    """The program of a tree whose numbers count from the first of their references."""
    nodes, parents, n_coarse = in_order(root)
    return Program(
        kinds=tuple(node.kind for node in nodes),
        parent=np.array(parents),
        member=np.array([node.member for node in nodes]),
        host=np.array([node.host for node in nodes]),
        shapes=tuple(node.shape for node in nodes),
        channels=np.array([node.channels for node in nodes]),
        references=np.zeros((len(nodes), len(REFERENCED)), dtype=np.int64),
        n_coarse=n_coarse,
        looks=tuple(tuple(node.looks) for node in nodes),
    )
