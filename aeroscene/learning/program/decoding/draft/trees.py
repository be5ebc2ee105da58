"""Reading of tokens as the records of a partition, whatever the tokens are.

A writer may draw trees that no partition has. They are made to fit: a slice has as many parts as
its token has children, a cross with too few cells becomes a slice, a missing node is a void leaf,
and a strip without a width takes a share.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import msgspec

from aeroscene.learning.program.kinds import FLAGS, NODES, OF_RECORD, Kind, SiteKind, same_part
from aeroscene.learning.program.nesting import Nested
from aeroscene.learning.program.program import Program
from aeroscene.learning.program.records import PARTS, shares_of, values_of
from aeroscene.partition import Record
from aeroscene.partition.tree import VOID
from aeroscene.relations.plane import QUARTER

Grown = Nested[int | None]
"""A record with the place of its token; None for a record that had to be made up."""


class TreeReader:
    """Reads the partitions of one program."""

    def __init__(self, program: Program, children: Sequence[Sequence[int]]) -> None:
        self._program, self.children = program, children
        self._n_widths = 0

    def head(self, place: int) -> tuple[Grown, list[Record]]:
        """Return the record of a site or storey with its tree, and the records of its widths."""
        below = self.children[place]
        kinds = self._program.kinds
        widths = [self._record(each) for each in below if kinds[each].node == "width"]
        # Strips may name these widths only.
        self._n_widths = len(widths)
        tree = self._node(next((each for each in below if kinds[each].node in NODES), None))
        grown = Grown(self._record(place), place, [tree])
        _limit_strips(grown, len(widths))
        _settle_shares(grown, self._logit)
        return grown, widths

    def border(self, place: int, n_widths: int) -> Grown:
        """Return the record of a border with its segments."""
        found = Grown(self._record(place), place, [])
        for each in self.children[place]:
            if self._program.kinds[each].node == "segment":
                found.children.append(Grown(self._record(each), each))
        found.record = replace(found.record, arity=len(found.children))
        _limit_strips(found, n_widths)
        _settle_shares(found, self._logit)
        return found

    def _logit(self, place: int | None) -> float:
        if place is None:
            return 0.0
        kinds = self._program.kinds
        # An even part copies the share of the last equal part before it.
        if kinds[place].is_even:
            beside = self.children[int(self._program.parent[place])]
            what = same_part(kinds[place])
            alike = (i for i in beside[: beside.index(place)] if same_part(kinds[i]) == what)
            with_share = [i for i in alike if not kinds[i].strip]
            return self._logit(with_share[-1]) if with_share else 0.0
        value = float(self._program.channels[place, 0])
        return 0.0 if math.isnan(value) else value

    def _record(self, place: int) -> Record:
        kind = self._program.kinds[place]
        record = record_of(kind)
        values = values_of(record, self._program.channels[place])
        if isinstance(kind, SiteKind):
            values = (*values[:2], values[2] + kind.turn * QUARTER, *values[3:])
        return replace(record, values=values)

    def _node(self, place: int | None) -> Grown:
        """Return a node of a tree with all below it; a void leaf for None."""
        if place is None:
            return _void()
        record = self._record(place)
        below = self.children[place]
        nodes = [self._node(each) for each in below if self._node_of(each) in NODES]
        match record.node:
            case "slice" if nodes:
                return Grown(replace(record, arity=len(nodes)), place, nodes)
            case "cross" | "grid" | "pinwheel":
                return self._checkered(record, place, nodes)
            case "overlay":
                # An overlay needs a leaf as its base.
                is_based = bool(nodes) and nodes[0].record.node == "leaf"
                items = [self._item(each) for each in below if self._node_of(each) == "item"]
                base = nodes[0] if is_based else _void()
                return Grown(replace(record, arity=len(items)), place, [base, *items])
            case "bend":
                return self._bend(record, place)
            case "leaf":
                return Grown(record, place)
            case _:
                return Grown(replace(_void().record, strip=record.strip), place)

    def _node_of(self, place: int) -> str:
        return self._program.kinds[place].node

    def _checkered(self, record: Record, place: int, nodes: list[Grown]) -> Grown:
        """Return a cross or a pinwheel, or a slice of its cells if they do not fill it."""
        below = self.children[place]
        parts = [Grown(self._record(i), i) for i in below if self._node_of(i) == "part"]
        is_cross = record.node != "pinwheel"
        n_parts = record.arity + record.rows if is_cross else 0
        n_cells = record.arity * record.rows if is_cross else 5
        if n_cells and len(parts) == n_parts and len(nodes) == n_cells:
            return Grown(record, place, [*parts, *nodes])
        if not nodes:
            return Grown(replace(_void().record, strip=record.strip), place)
        record = Record("slice", "x", len(nodes), strip=record.strip)
        return Grown(record, place, nodes)

    def _item(self, place: int) -> Grown:
        below = (each for each in self.children[place] if self._node_of(each) in NODES)
        return Grown(self._record(place), place, [self._node(next(below, None))])

    def _bend(self, record: Record, place: int) -> Grown:
        below = self.children[place]
        lanes = [Grown(self._record(i), i) for i in below if self._node_of(i) == "lane"]
        banks = [self._bank(i) for i in below if self._node_of(i) == "bank"]
        if not lanes or not self._n_widths or record.arity < 1:
            return Grown(replace(_void().record, strip=record.strip), place)
        banks += [Grown(Record("bank"), None) for _ in range(2 * record.arity - len(banks))]
        for lane in lanes:
            # A lane without a height is as high as a sidewalk; missing heights repeat the last one.
            known = lane.record.values or (0.15,)
            heights = (*known, *known[-1:] * record.arity)[: record.arity]
            lane.record = replace(lane.record, values=heights, strip=max(1, lane.record.strip))
        record = replace(record, rows=len(lanes))
        return Grown(record, place, [*lanes, *banks[: 2 * record.arity]])

    def _bank(self, place: int) -> Grown:
        record = self._record(place)
        below = [each for each in self.children[place] if self._node_of(each) in NODES]
        if not record.is_placed or not below:
            return Grown(Record("bank"), place)
        return Grown(record, place, [self._node(below[0])])


def record_of(kind: Kind) -> Record:
    """Return the record of a kind, without numbers."""
    said = ""
    if kind.node == "border":
        said = str(dict(kind.attributes).get("form", ""))
    elif kind.domain:
        said = msgspec.json.encode(kind.what).decode()
    elif kind.node != "width":
        said = kind.category
    names = OF_RECORD[kind.node]
    own: dict[str, Any] = {name: getattr(kind, name) for name in names}
    own |= {name: bool(own[name]) for name in FLAGS & names}
    return Record(kind=said, **own)


def _void() -> Grown:
    return Grown(Record("leaf", kind=VOID, values=(0.0,)), None)


def _limit_strips(grown: Grown, n_widths: int) -> None:
    """Turn strips whose width does not exist into shares; lanes take the first width."""
    record = grown.record
    if record.strip > n_widths:
        is_lane = record.node == "lane"
        grown.record = replace(record, strip=min(1, n_widths) if is_lane else 0)
    for child in grown.children:
        _limit_strips(child, n_widths)


def _settle_shares(grown: Grown, logit: Callable[[int | None], float]) -> None:
    """Give each part of a side its share; the shares of parts without a width sum to one."""
    record = grown.record
    for low, high in PARTS.get(record.node, lambda _: ())(record):
        parts = grown.children[low:high]
        # Widths alone would not fill the side: the last one takes the rest.
        if parts and all(part.record.strip for part in parts):
            parts[-1].record = replace(parts[-1].record, strip=0)
        logits = [math.nan if p.record.strip else logit(p.token) for p in parts]
        for part, share in zip(parts, shares_of(logits), strict=True):
            part.record = replace(part.record, share=share)
    for child in grown.children:
        _settle_shares(child, logit)
