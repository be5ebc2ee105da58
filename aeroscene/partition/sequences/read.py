"""Reading of records as the partition that they describe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

from aeroscene.partition.frames import Frame
from aeroscene.partition.sequences.record import Partition, Record
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
)


def from_sequence(records: Sequence[Record]) -> Partition:
    """Return the partition of a list of records; inverse of `to_sequence`.

    Raises:
        PartitionError: If they are not the records of one partition.
    """
    widths = [record.values[0] for record in records if record.node == "width"]
    reader = _Reader(list(records[len(widths) :]), widths)
    try:
        return reader.partition()
    # Malformed lists fail somewhere in the reader; all such errors become one.
    except (IndexError, KeyError, TypeError) as error:
        raise PartitionError(f"sequence has a record that does not fit: {error}") from None


def read_border(records: Sequence[Record]) -> Border:
    """Return the border of a list of records.

    Args:
        records: Records of the widths that it may name, then those of the border.
    """
    widths = [record.values[0] for record in records if record.node == "width"]
    reader = _Reader(list(records[len(widths) :]), widths)
    return reader.border(reader.take("border"))


class _Reader:
    def __init__(self, records: list[Record], widths: list[float]) -> None:
        self.records, self.widths, self.at = records, widths, 0

    def take(self, *nodes: str) -> Record:
        """Return the next record, which must have one of these nodes."""
        found = self.records[self.at] if self.at < len(self.records) else None
        if found is None or (nodes and found.node not in nodes):
            name = "ends" if found is None else f"has {found.node!r}"
            valid = ", ".join(nodes) or "a node"
            raise PartitionError(f"sequence {name} at record {self.at}; valid: {valid}")
        self.at += 1
        return found

    def partition(self) -> Partition:
        head = self.take("site", "storey")
        # The last value is the base of a site, or the drop of a storey's walls.
        *values, last = head.values
        frame, tree = Frame(*values[:5]), self.node(self.take())
        # A site has no borders, so its tree is the end.
        if head.node == "site":
            if self.at < len(self.records):
                raise PartitionError("sequence goes on behind its site; valid: one partition")
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
            is_inset=head.is_inset,
        )

    def part(self, record: Record) -> Part:
        if record.strip:
            return Part(self.widths[record.strip - 1], is_width=True)
        return Part(record.share)

    def many(self, count: int) -> tuple[Node, ...]:
        # `strip` counts from 1, because 0 means a share.
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
                return Pinwheel(r.is_mirrored, (a, b, c, d), (south, east, north, west), middle)
            case "overlay":
                head = self.take("leaf")
                base = Leaf(head.kind, head.values[0], head.quarter, head.merge)
                return Overlay(base, tuple(self.item() for _ in range(r.arity)))
            case "bend":
                return self.bend(r)
            case _:
                raise PartitionError(
                    f"sequence has {r.node!r} at record {self.at - 1}; valid: a node"
                )

    def item(self) -> Item:
        head = self.take("item")
        tree = self.node(self.take())
        if not head.is_placed:
            return Item(tree)
        x, y, yaw, length, width = head.values
        return Item(tree, Place(x, y, yaw, (length, width)))

    def bend(self, r: Record) -> Bend:
        lanes = [self.take("lane") for _ in range(r.rows)]
        u, v, heading, *numbers = r.values
        banks: list[Bank | None] = []
        for _ in range(2 * r.arity):
            bank = self.take("bank")
            tree = self.node(self.take()) if bank.is_placed else None
            banks.append(None if tree is None else Bank(*bank.values, tree=tree))
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
        # A record's kind is any text; only these four are segments.
        kinds: dict[str, SegmentKind] = {kind: kind for kind in get_args(SegmentKind)}
        return Border(
            tuple(Segment(kinds[s.kind], self.part(s), *s.values) for s in segments), r.kind
        )
