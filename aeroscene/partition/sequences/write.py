"""Writing of a partition as its records."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, replace

from aeroscene.partition.sequences.record import Partition, Record
from aeroscene.partition.sites.site import SitePartition
from aeroscene.partition.storeys.storey import OPEN, Border, StoreyPartition
from aeroscene.partition.tree import (
    Bend,
    Cross,
    Item,
    Leaf,
    Node,
    Overlay,
    Part,
    Pinwheel,
    Slice,
    walk,
)


def to_sequence(partition: Partition) -> list[Record]:
    """Return the records of a partition.

    `from_sequence` gives the partition back without loss.

    Args:
        partition: A site or a storey.
    """
    widths = _widths_of(partition)
    writer = _Writer({width: number for number, width in enumerate(widths, 1)})
    # Widths first, because later records name them by number.
    head = [Record("width", values=(width,)) for width in widths]
    frame = astuple(partition.frame)
    match partition:
        case SitePartition():
            head.append(Record("site", values=(*frame, partition.base_m)))
            return head + list(writer.node(partition.tree))
        case StoreyPartition():
            p = partition
            values = (*frame, p.level_m, p.wall_m, p.outer_m, p.drop_m)
            head.append(Record("storey", is_inset=p.is_inset, values=values))
            return [*head, *writer.node(p.tree), *(r for b in p.borders for r in writer.border(b))]


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
        # Doors and windows share widths too: one door width serves a whole house.
        parts += (s.part for border in partition.borders for s in border.segments)
    # Equal widths are one record, in the order of their first use.
    return list(dict.fromkeys(part.value for part in parts if part.is_width))


class _Writer:
    def __init__(self, numbers: dict[float, int]) -> None:
        self.numbers = numbers

    def part(self, record: Record, part: Part) -> Record:
        if part.is_width:
            return replace(record, strip=self.numbers[part.value])
        return replace(record, share=part.value)

    def node(self, node: Node, part: Part | None = None) -> Iterator[Record]:
        """Yield the records of a node; the first states the node's part of its parent."""
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
                yield Record("pinwheel", is_mirrored=node.is_mirrored, values=node.cuts)
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
        yield Record("item", is_placed=p is not None, values=values)
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
            values = (bank.low_share, bank.high_share, bank.depth_m)
            yield Record("bank", is_placed=True, values=values)
            yield from self.node(bank.tree)

    def border(self, border: Border) -> Iterator[Record]:
        if border == OPEN:
            yield Record("border")
            return
        yield Record("border", "", len(border.segments), kind=border.form)
        for s in border.segments:
            yield self.part(Record("segment", kind=s.kind, values=(s.sill_m, s.head_m)), s.part)
