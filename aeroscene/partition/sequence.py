"""Trees as flat lists of small records in pre-order, and back without loss: what a model embeds.

A record's discrete fields say what comes; its numbers say how large. A partition begins with the
widths that its strips share (doors and windows too), so that `strip` can name them.

| record | then come | arity, rows | values |
|---|---|---|---|
| `width` | | | metres |
| `site` | tree | | frame (x, y, yaw, length, width), base |
| `storey` | tree, borders to the end | 1 if inset | frame, level, walls, outer walls, drop |
| `leaf` | | | height |
| `slice` | children, each with its `share` or `strip` | children | |
| `cross`, `grid` | `part` for each column and row, cells | columns, rows | |
| `pinwheel` | arms, middle | 1 if mirrored | west, east, south, north |
| `overlay` | its leaf, items | items | |
| `item` | tree | | none, or x, y, yaw, length, width |
| `bend` | lanes, banks | pieces, lanes | start, heading, lengths, turns |
| `lane` | | | a height for each piece |
| `bank` | tree, if it has values | | low, high, depth |
| `border` | segments; none is open | segments | |
| `segment` | | | sill, head |
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from typing import get_args

from aeroscene.partition.frames import Frame
from aeroscene.partition.sites.site import SitePartition
from aeroscene.partition.storeys.storey import OPEN, Border, Segment, SegmentKind, StoreyPartition
from aeroscene.partition.tree import (
    Bank,
    Bend,
    Cross,
    Item,
    Lane,
    Leaf,
    Node,
    Overlay,
    Part,
    PartitionError,
    Pinwheel,
    Place,
    Slice,
    walk,
)

Partition = SitePartition | StoreyPartition


@dataclass(frozen=True, slots=True)
class Record:
    """One symbol of a sequence with its numbers."""

    node: str
    axis: str = ""
    arity: int = 0
    rows: int = 0
    kind: str = ""
    merge: int = 0
    quarter: int = 0
    strip: int = 0
    """Number of the width, from 1, that this has in its parent; 0 where it has a share."""
    share: float = 0.0
    values: tuple[float, ...] = ()

    @property
    def symbol(self) -> tuple[str | int, ...]:
        """All that is discrete."""
        return (
            self.node,
            self.axis,
            self.arity,
            self.rows,
            self.kind,
            self.merge,
            self.quarter,
            self.strip,
        )


def to_sequence(partition: Partition) -> list[Record]:
    """The records of a partition."""
    widths = _widths_of(partition)
    writer = _Writer({width: number for number, width in enumerate(widths, 1)})
    head = [Record("width", values=(width,)) for width in widths]
    frame = astuple(partition.frame)
    match partition:
        case SitePartition():
            head.append(Record("site", values=(*frame, partition.base_m)))
            return head + list(writer.node(partition.tree))
        case StoreyPartition():
            p = partition
            values = (*frame, p.level_m, p.wall_m, p.outer_m, p.drop_m)
            head.append(Record("storey", "", int(p.is_inset), values=values))
            return [*head, *writer.node(p.tree), *(r for b in p.borders for r in writer.border(b))]


def from_sequence(records: Sequence[Record]) -> Partition:
    """The partition whose records these are.

    Raises:
        PartitionError: If they are not the records of one partition.
    """
    widths = [record.values[0] for record in records if record.node == "width"]
    reader = _Reader(list(records[len(widths) :]), widths)
    try:
        return reader.partition()
    except (IndexError, KeyError, TypeError) as error:
        raise PartitionError(f"sequence has a record that does not fit: {error}") from None


def _widths_of(partition: Partition) -> list[float]:
    parts: list[Part] = []
    for node in walk(partition.tree):
        match node:
            case Slice():
                parts += node.parts
            case Cross():
                parts += (*node.columns, *node.rows)
            case Bend():
                parts += (Part(lane.width_m, is_width=True) for lane in node.lanes)
            case _:
                pass
    if isinstance(partition, StoreyPartition):
        parts += (s.part for border in partition.borders for s in border.segments)
    return list(dict.fromkeys(part.value for part in parts if part.is_width))


class _Writer:
    def __init__(self, numbers: dict[float, int]) -> None:
        self.numbers = numbers

    def part(self, record: Record, part: Part) -> Record:
        if part.is_width:
            return replace(record, strip=self.numbers[part.value])
        return replace(record, share=part.value)

    def node(self, node: Node, part: Part | None = None) -> Iterator[Record]:
        """Records of a node; the first says what part of its parent it is."""
        first, *rest = self._whole(node)
        yield self.part(first, part) if part else first
        yield from rest

    def _whole(self, node: Node) -> Iterator[Record]:
        match node:
            case Leaf():
                yield Record(
                    "leaf",
                    kind=node.kind,
                    merge=node.merge,
                    quarter=node.quarter,
                    values=(node.height_m,),
                )
            case Slice():
                yield Record("slice", node.axis, len(node.children))
                for child, part in zip(node.children, node.parts, strict=True):
                    yield from self.node(child, part)
            case Cross():
                name = "grid" if node.is_fallback else "cross"
                yield Record(name, "", len(node.columns), len(node.rows))
                yield from (self.part(Record("part"), p) for p in (*node.columns, *node.rows))
                for cell in node.cells:
                    yield from self.node(cell)
            case Pinwheel():
                yield Record("pinwheel", "", int(node.is_mirrored), values=node.cuts)
                for child in (*node.arms, node.middle):
                    yield from self.node(child)
            case Overlay():
                yield Record("overlay", "", len(node.items))
                yield from self.node(node.base)
                for item in node.items:
                    yield from self._item(item)
            case Bend():
                yield from self._bend(node)

    def _item(self, item: Item) -> Iterator[Record]:
        p = item.place
        values = () if p is None else (p.x_share, p.y_share, p.yaw_rad, *p.size_m)
        yield Record("item", values=values)
        yield from self.node(item.tree)

    def _bend(self, bend: Bend) -> Iterator[Record]:
        values = (*bend.start, bend.heading_rad, *bend.lengths_m, *bend.turns_rad)
        yield Record("bend", "", len(bend.lengths_m), len(bend.lanes), values=values)
        for lane in bend.lanes:
            record = Record("lane", kind=lane.kind, quarter=lane.quarter, values=lane.heights_m)
            yield self.part(record, Part(lane.width_m, is_width=True))
        for bank in bend.banks:
            if bank is None:
                yield Record("bank")
                continue
            yield Record("bank", values=(bank.low_share, bank.high_share, bank.depth_m))
            yield from self.node(bank.tree)

    def border(self, border: Border) -> Iterator[Record]:
        if border == OPEN:
            yield Record("border")
            return
        yield Record("border", "", len(border.segments), kind=border.form)
        for s in border.segments:
            yield self.part(Record("segment", kind=s.kind, values=(s.sill_m, s.head_m)), s.part)


class _Reader:
    def __init__(self, records: list[Record], widths: list[float]) -> None:
        self.records, self.widths, self.at = records, widths, 0

    def take(self, *nodes: str) -> Record:
        """The next record, which is one of these."""
        found = self.records[self.at] if self.at < len(self.records) else None
        if found is None or (nodes and found.node not in nodes):
            name = "ends" if found is None else f"has {found.node!r}"
            valid = ", ".join(nodes) or "a node"
            raise PartitionError(f"sequence {name} at record {self.at}, valid: {valid}")
        self.at += 1
        return found

    def partition(self) -> Partition:
        head = self.take("site", "storey")
        *values, last = head.values
        frame, tree = Frame(*values[:5]), self.node(self.take())
        if head.node == "site":
            if self.at < len(self.records):
                raise PartitionError("sequence goes on behind its site, valid: one partition")
            return SitePartition(frame=frame, tree=tree, base_m=last)
        borders: list[Border] = []
        while self.at < len(self.records):
            borders.append(self.border(self.take("border")))
        _, _, _, _, _, level, wall, outer = values
        return StoreyPartition(
            frame=frame,
            level_m=level,
            tree=tree,
            borders=tuple(borders),
            wall_m=wall,
            outer_m=outer,
            drop_m=last,
            is_inset=bool(head.arity),
        )

    def part(self, record: Record) -> Part:
        if record.strip:
            return Part(self.widths[record.strip - 1], is_width=True)
        return Part(record.share)

    def many(self, count: int) -> tuple[Node, ...]:
        return tuple(self.node(self.take()) for _ in range(count))

    def node(self, r: Record) -> Node:
        match r.node:
            case "leaf":
                return Leaf(r.kind, r.values[0], r.quarter, r.merge)
            case "slice":
                heads: list[Record] = []
                nodes: list[Node] = []
                for _ in range(r.arity):
                    heads.append(self.take())
                    nodes.append(self.node(heads[-1]))
                return Slice(
                    "x" if r.axis == "x" else "y", tuple(map(self.part, heads)), tuple(nodes)
                )
            case "cross" | "grid":
                parts = [self.part(self.take("part")) for _ in range(r.arity + r.rows)]
                columns, rows = tuple(parts[: r.arity]), tuple(parts[r.arity :])
                cells = self.many(r.arity * r.rows)
                return Cross(columns, rows, cells, is_fallback=r.node == "grid")
            case "pinwheel":
                south, east, north, west, middle = self.many(5)
                a, b, c, d = r.values
                return Pinwheel(bool(r.arity), (a, b, c, d), (south, east, north, west), middle)
            case "overlay":
                head = self.take("leaf")
                base = Leaf(head.kind, head.values[0], head.quarter, head.merge)
                return Overlay(base, tuple(self.item() for _ in range(r.arity)))
            case "bend":
                return self.bend(r)
            case _:
                raise PartitionError(
                    f"sequence has {r.node!r} at record {self.at - 1}, valid: a node"
                )

    def item(self) -> Item:
        values = self.take("item").values
        tree = self.node(self.take())
        if not values:
            return Item(tree)
        x, y, yaw, length, width = values
        return Item(tree, Place(x, y, yaw, (length, width)))

    def bend(self, r: Record) -> Bend:
        lanes = [self.take("lane") for _ in range(r.rows)]
        u, v, heading, *numbers = r.values
        banks: list[Bank | None] = []
        for _ in range(2 * r.arity):
            values = self.take("bank").values
            banks.append(Bank(*values, tree=self.node(self.take())) if values else None)
        return Bend(
            (u, v),
            heading,
            tuple(numbers[: r.arity]),
            tuple(numbers[r.arity :]),
            tuple(Lane(n.kind, self.part(n).value, n.values, n.quarter) for n in lanes),
            tuple(banks),
        )

    def border(self, r: Record) -> Border:
        segments = [self.take("segment") for _ in range(r.arity)]
        if not segments:
            return OPEN
        kinds: dict[str, SegmentKind] = {kind: kind for kind in get_args(SegmentKind)}
        return Border(
            tuple(Segment(kinds[s.kind], self.part(s), *s.values) for s in segments), r.kind
        )
