"""The data structure of a program: a tree of tokens, coarse ones first, in arrays."""

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
"""Channels of a unit."""
SIZE, PITCH, OPENING, TILT = slice(5, 8), slice(8, 10), slice(10, 17), slice(17, 19)
"""Channels of a unit; a record has its share first and its numbers after it."""
REFERENCED = (RISE, 5, 6, 7)
"""Channels that may count from several references, see `aeroscene.learning.program.references`."""
N_MEMBERS, N_HOSTS = 16, 32
"""Numbers of members and ranks of hosts that networks tell apart; greater ones count as the
last."""

Looks = dict[str, AttributeValue]


class ProgramError(ValueError):
    """A scene has no program; one line names the object and the reason."""


class Shape(NamedTuple):
    """The discrete part of a group's array."""

    rows: int = 1
    columns: int = 1
    holes: tuple[int, ...] = ()
    turned: tuple[int, ...] = ()

    @staticmethod
    def from_array(array: Array | None) -> Shape:
        """Return the shape of an array; a single cell for one object."""
        if array is None:
            return Shape()
        return Shape(array.rows, array.columns, array.holes, array.turned)

    def array(self, pitch_m: tuple[float, float] = (0.0, 0.0)) -> Array:
        """Return the array of such a group with some pitch."""
        return Array(
            rows=self.rows,
            columns=self.columns,
            pitch_m=pitch_m,
            holes=self.holes,
            turned=self.turned,
        )


@dataclass(slots=True, eq=False)
class Node:
    """A token in a tree, while the tree is built."""

    kind: Kind
    channels: Float[np.ndarray, " 19"] = field(default_factory=lambda: np.full(N_CHANNELS, np.nan))
    member: int = 0
    host: int = 0
    shape: Shape = field(default_factory=Shape)
    choices: Float[np.ndarray, "4 4"] | None = None
    """Value of each of `REFERENCED` from each reference."""
    looks: list[Looks] = field(default_factory=list)
    beside: str = ""
    """Key of a unit's host, see `aeroscene.learning.program.companions`."""
    ids: list[int] = field(default_factory=list)
    """Ids of the objects that the token stands for."""
    children: list[Node] = field(default_factory=list)

    def add(self, child: Node) -> Node:
        """Append a child and return it."""
        self.children.append(child)
        return child


@dataclass(frozen=True, eq=False, kw_only=True)
class Program:
    """A scene as tokens: the scene's own first, coarse ones depth first, then the fine ones."""

    kinds: tuple[Kind, ...]
    parent: Int[np.ndarray, " n"]
    """Places of the parents; the scene is its own parent."""
    member: Int[np.ndarray, " n"]
    """Number of the object of the parent's token that bears the token."""
    host: Int[np.ndarray, " n"]
    """Rank of the host. For a border, the number of leaves to the room beyond it."""
    shapes: tuple[Shape, ...]
    channels: Float[np.ndarray, "n channels"]
    """Numbers of each token; NaN where it has none."""
    references: Int[np.ndarray, "n 4"]
    """Reference from which each of `REFERENCED` counts."""
    n_coarse: int
    looks: tuple[tuple[Looks, ...], ...] = ()
    """Looks of the objects of each token in turn; empty until drawn."""
    clearances: Clearances = NO_CLEARANCES
    """Distances that units keep where they look for room; none in a program that was read off a
    scene."""
    companions: Companions = ANY_COMPANIONS
    """Hosts that units may stand beside; any in a program that was read off a scene."""

    def __len__(self) -> int:
        return len(self.kinds)

    def unit(self, place: int) -> UnitKind:
        """Return the kind of a token that is a unit; the caller knows that it is one."""
        kind = self.kinds[place]
        assert isinstance(kind, UnitKind)
        return kind

    def with_channels(self, channels: Float[np.ndarray, "n channels"]) -> Program:
        """Return the same tokens with other numbers."""
        return replace(self, channels=channels)

    def children(self) -> list[list[int]]:
        """Return the places of the children of each token, in order."""
        found: list[list[int]] = [[] for _ in self.kinds]
        for place, parent in enumerate(self.parent.tolist()):
            # Token 0 is its own parent, and nobody's child.
            if place:
                found[parent].append(place)
        return found


def in_order(root: Node) -> tuple[list[Node], list[int], int]:
    """Sort the nodes of a tree into a program's order.

    Args:
        root: Node of the scene.

    Returns:
        The nodes, the places of their parents, and the number of coarse nodes, which come first.
    """
    # Two walks: the networks need all coarse tokens before the first fine one.
    coarse: list[tuple[Node, Node]] = []
    _descend(root, root, coarse, is_coarse=True)
    # Fine nodes follow in the order of the coarse nodes that bear them.
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
    """Turn a tree into a program in which every number counts from its first reference."""
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
