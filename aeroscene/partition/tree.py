"""The partition tree: the division of a rectangle of ground, or of a storey, without a rest.

Every node fills the frame that it is given: an upright rectangle with a heading of its own. Lengths
along a frame are shares of it, so that a tree fits a frame of any size. Strips such as carriageways
are the exception, because their width is given in metres. Lists along x or y begin at the low end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

Axis = Literal["x", "y"]

VOID = "void"
"""Kind of a leaf that nothing fills."""
# Shares come from sums and quotients, whose rounding errors stay below this.
SHARES_TOLERANCE = 1e-6


class PartitionError(ValueError):
    """A tree does not divide its frame; one line names node, field and value."""


@dataclass(frozen=True, slots=True)
class Part:
    """One stretch of a frame's side."""

    value: float
    """Width of a strip in m, or the share of the length that the strips of the side leave."""
    is_width: bool = False


@dataclass(frozen=True, slots=True)
class Leaf:
    """An area that one kind of cover or room fills, or nothing."""

    kind: str
    """Word for its content: the category, unless the parser was given another word; `VOID` for
    nothing."""
    height_m: float = 0.0
    """Distance from its underside to its upper face."""
    quarter: int = 0
    """Quarter turns of its own x axis, counter-clockwise from the frame's: 0 to 3."""
    merge: int = 0
    """Leaves of one number above 0 are one room or one ground object; a leaf with 0 is one by
    itself."""

    def __post_init__(self) -> None:
        if self.quarter not in range(4):
            raise PartitionError(f"leaf.quarter is {self.quarter!r}; valid: 0 to 3")


@dataclass(frozen=True, slots=True)
class Slice:
    """Children side by side along an axis."""

    axis: Axis
    parts: tuple[Part, ...]
    children: tuple[Node, ...]

    def __post_init__(self) -> None:
        _check_parts("slice.parts", self.parts)
        _check_count("slice.children", self.children, len(self.parts))


@dataclass(frozen=True, slots=True)
class Cross:
    """Columns times rows of cells, row by row; leaves of one merge number bridge cells."""

    columns: tuple[Part, ...]
    rows: tuple[Part, ...]
    cells: tuple[Node, ...]
    is_fallback: bool = False
    """True for a grid that holds a layout which no other node fits."""

    def __post_init__(self) -> None:
        _check_parts("cross.columns", self.columns)
        _check_parts("cross.rows", self.rows)
        _check_count("cross.cells", self.cells, len(self.columns) * len(self.rows))


@dataclass(frozen=True, slots=True)
class Pinwheel:
    """Four arms around a middle, each ending on the next."""

    is_mirrored: bool
    """True if the southern arm ends at the eastern side; otherwise it begins at the western one."""
    cuts: tuple[float, float, float, float]
    """Sides of the middle as shares of the frame: west, east, south, north."""
    arms: tuple[Node, Node, Node, Node]
    """South, east, north, west."""
    middle: Node

    def __post_init__(self) -> None:
        west, east, south, north = self.cuts
        # The middle touches no side of the frame, or it would be no pinwheel.
        if not (0 < west < east < 1 and 0 < south < north < 1):
            raise PartitionError(f"pinwheel.cuts is {self.cuts}; valid: 0 < low < high < 1")


@dataclass(frozen=True, slots=True)
class Place:
    """A rectangle anywhere in a frame."""

    x_share: float
    """Middle, in shares of the frame from its south-western corner."""
    y_share: float
    yaw_rad: float
    """Heading relative to the frame's."""
    size_m: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Item:
    """A tree on a leaf: over all of it, or at a place."""

    tree: Node
    place: Place | None = None
    """None if the tree fills the leaf."""


@dataclass(frozen=True, slots=True)
class Overlay:
    """A leaf and the trees on top of it."""

    base: Leaf
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True)
class Lane:
    """A strip along all pieces of a bend."""

    kind: str
    width_m: float
    heights_m: tuple[float, ...]
    """Height on each piece."""
    quarter: int = 0


@dataclass(frozen=True, slots=True)
class Bank:
    """A frame beside a piece of a bend, with a tree of its own."""

    low_share: float
    """Begin along the piece, in shares of its middle line; may be negative."""
    high_share: float
    """End along the piece, in shares of its middle line; may exceed 1."""
    depth_m: float
    tree: Node


@dataclass(frozen=True, slots=True)
class Bend:
    """A chain of straight pieces with lanes.

    Wedges in the bends beyond the lanes stay empty.
    """

    start: tuple[float, float]
    """Begin of the middle line, in shares of the frame from its south-western corner."""
    heading_rad: float
    """Heading of the first piece relative to the frame's."""
    lengths_m: tuple[float, ...]
    turns_rad: tuple[float, ...]
    """Left turns between pieces, one fewer than pieces."""
    lanes: tuple[Lane, ...]
    """From the right edge to the left."""
    banks: tuple[Bank | None, ...]
    """Right and left of each piece; x of their frames is the piece's direction."""

    def __post_init__(self) -> None:
        n = len(self.lengths_m)
        _check_count("bend.turns_rad", self.turns_rad, n - 1)
        _check_count("bend.banks", self.banks, 2 * n)
        for lane in self.lanes:
            _check_count("bend.lanes.heights_m", lane.heights_m, n)

    @property
    def width_m(self) -> float:
        """Width of all lanes together."""
        return sum(lane.width_m for lane in self.lanes)


Node = Leaf | Slice | Cross | Pinwheel | Overlay | Bend


def children(node: Node) -> tuple[Node, ...]:
    """Return the nodes right below a node, in order.

    An overlay's leaf is its first child, and absent banks of a bend are left out.
    """
    match node:
        case Leaf():
            return ()
        case Slice():
            return node.children
        case Cross():
            return node.cells
        case Pinwheel():
            return (*node.arms, node.middle)
        case Overlay():
            return (node.base, *(item.tree for item in node.items))
        case Bend():
            return tuple(bank.tree for bank in node.banks if bank)


def with_children(node: Node, nodes: tuple[Node, ...]) -> Node:
    """Return a node with others in place of its `children`.

    Raises:
        PartitionError: If the base of an overlay is no leaf.
    """
    match node:
        case Leaf():
            return node
        case Slice():
            return replace(node, children=nodes)
        case Cross():
            return replace(node, cells=nodes)
        case Pinwheel():
            south, east, north, west, middle = nodes
            return replace(node, arms=(south, east, north, west), middle=middle)
        case Overlay():
            base, *trees = nodes
            items = zip(node.items, trees, strict=True)
            if not isinstance(base, Leaf):
                raise PartitionError(f"overlay.base is {base}; valid: a leaf")
            return Overlay(base, tuple(replace(item, tree=tree) for item, tree in items))
        case Bend():
            trees = iter(nodes)
            # Only banks with a tree are among the children, see `children`.
            banks = tuple(bank and replace(bank, tree=next(trees)) for bank in node.banks)
            return replace(node, banks=banks)


def walk(node: Node) -> Iterator[Node]:
    """Yield a node and everything below it, in pre-order.

    Sequences and cells have the same order, so numbers of leaves agree.
    """
    yield node
    for child in children(node):
        yield from walk(child)


def part_lengths(parts: tuple[Part, ...], length_m: float) -> list[float]:
    """Return the lengths in m of the parts that fill a side.

    Raises:
        PartitionError: If the strips alone are as long as the side.
    """
    fixed = sum(part.value for part in parts if part.is_width)
    if fixed >= length_m:
        raise PartitionError(f"strips are {fixed:.3f} m wide; valid: below {length_m:.3f} m")
    # Strips keep their metres; shares divide the rest.
    return [part.value if part.is_width else part.value * (length_m - fixed) for part in parts]


def parts_of(lengths_m: Sequence[float], is_width: Sequence[bool]) -> tuple[Part, ...]:
    """Return the parts of a side; if all would be widths, the longest becomes a share.

    Args:
        lengths_m: Lengths of the parts.
        is_width: True for parts that are strips.
    """
    widths = list(is_width)
    # Without any share, a side of another length could not be filled.
    if all(widths):
        widths[max(range(len(lengths_m)), key=lengths_m.__getitem__)] = False
    pairs = list(zip(lengths_m, widths, strict=True))
    rest = sum(length for length, is_fixed in pairs if not is_fixed)
    return tuple(Part(v, is_fixed) if is_fixed else Part(v / rest) for v, is_fixed in pairs)


def _check_parts(name: str, parts: tuple[Part, ...]) -> None:
    shares = [part.value for part in parts if not part.is_width]
    if min((part.value for part in parts), default=0.0) <= 0.0:
        raise PartitionError(f"{name} is {parts}; valid: values above 0")
    # A side of strips alone has no shares, whose sum is 0, and is refused as well.
    if not math.isclose(sum(shares), 1.0, abs_tol=SHARES_TOLERANCE):
        raise PartitionError(f"{name} has shares {shares}; valid: shares that sum to 1")


def _check_count(name: str, values: tuple[object, ...], count: int) -> None:
    if len(values) != count:
        raise PartitionError(f"{name} has {len(values)} entries; valid: {count}")
