"""Partitions as nodes of a program.

A partition is a sequence of records. Here it becomes a tree of nodes below the site or a storey,
and each border of a room becomes a child of the room's first leaf. A border that is all wall or all
open needs no segments, which shortens most programs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import msgspec

from aeroscene.learning.program.encoding.units import SAME_RAD
from aeroscene.learning.program.kinds import FLAGS, KINDS, OF_RECORD, Kind, Word, same_part
from aeroscene.learning.program.nesting import Nested, cells, nest
from aeroscene.learning.program.program import Node
from aeroscene.learning.program.records import PARTS, channels_of, share_logits
from aeroscene.partition import Record, SitePartition, StoreyPartition, storey_lines, to_sequence
from aeroscene.partition.storeys.storey import NOBODY, Line, room_numbers, storey_cells
from aeroscene.relations.plane import Rectangle, nearest_quadrant

Cells = list[tuple[Node, int]]
"""Node of each leaf of a partition, and the number of its object among the node's."""
_SAME_LOGIT = 1e-3
"""Logs of shares that differ by less belong to equal parts."""
SIDES = {("y", True): 0, ("x", True): 1, ("y", False): 2, ("x", False): 3}
"""Side of a room, by the axis of a line there and True if the room is on its lower side."""


def site_node(site: SitePartition) -> tuple[Node, Cells]:
    """Return the node of a site's partition with everything below it, and its leaves' nodes."""
    head, found = _grown(to_sequence(site))
    quarters, own_rad = nearest_quadrant(site.frame.yaw_rad)
    is_turned = abs(own_rad) > SAME_RAD
    head.kind = msgspec.structs.replace(head.kind, turn=quarters, is_turned=is_turned)
    own = (math.cos(own_rad), math.sin(own_rad)) if is_turned else (math.nan, math.nan)
    head.channels[3:5] = own
    return head, found


def storey_node(
    storey: StoreyPartition, host: Rectangle, below_m: float, *, is_first: bool
) -> tuple[Node, Cells, list[Node]]:
    """Return the node of a storey's partition, its leaves' nodes, and those of its borders.

    Args:
        storey: The partition.
        host: The building, or the site, seen from above.
        below_m: Level from which the storey's level counts: of the storey below, or of the
            building.
        is_first: True if it states the frame; the storeys above have the same.
    """
    records = to_sequence(storey)
    n_tree = next((i for i, r in enumerate(records) if r.node == "border"), len(records))
    head, found = _grown(records)
    head.kind = msgspec.structs.replace(head.kind, is_first=int(is_first))
    head.channels[1:11] = _storey_values(storey, host, below_m)
    # The frame's six channels are stated by the lowest storey alone.
    if not is_first:
        head.channels[1:7] = math.nan
    borders = _add_borders(storey, records[n_tree:], found)
    return head, found, borders


def _storey_values(storey: StoreyPartition, host: Rectangle, below_m: float) -> list[float]:
    f = storey.frame
    cos, sin = math.cos(host.place.yaw_rad), math.sin(host.place.yaw_rad)
    dx, dy = f.x_enu_m - host.place.x_m, f.y_enu_m - host.place.y_m
    turn = f.yaw_rad - host.place.yaw_rad
    return [
        cos * dx + sin * dy,
        cos * dy - sin * dx,
        math.cos(turn),
        math.sin(turn),
        2 * host.half_m[0] - f.length_m,
        2 * host.half_m[1] - f.width_m,
        storey.level_m - below_m,
        storey.wall_m,
        storey.outer_m,
        storey.drop_m,
    ]


def _grown(records: Sequence[Record]) -> tuple[Node, Cells]:
    """Return the node of a head, with its widths and its tree below it.

    A width is labelled with the category of its first user.
    """
    n_widths = sum(record.node == "width" for record in records)
    nested = nest(iter(records[n_widths:]))
    tree = _with_nodes(nested, math.nan)
    widths = [
        Node(_kind(Record("width", kind=_first_use(records, n))), channels_of(record))
        for n, record in enumerate(records[:n_widths], 1)
    ]
    tree.token.children[:0] = widths
    return tree.token, cells(tree)


def _first_use(records: Sequence[Record], strip: int) -> str:
    """Return the first user of a width: the category of the next leaf, lane or segment."""
    at = next((i for i, record in enumerate(records) if record.strip == strip), len(records))
    for record in records[at:]:
        if record.node in {"leaf", "lane", "segment"} and record.kind:
            return record.kind
    return ""


def _with_nodes(nested: Nested[None], logit: float, *, is_even: bool = False) -> Nested[Node]:
    """Build a record's tree with a node for each record."""
    record = nested.record
    logits = [math.nan] * len(nested.children)
    even = [False] * len(nested.children)
    for low, high in PARTS.get(record.node, lambda _: ())(record):
        parts = [child.record for child in nested.children[low:high]]
        logits[low:high] = share_logits([part.share for part in parts])
        even[low:high] = _are_even(parts, logits[low:high])
    node = Node(_kind(record, is_even=is_even), channels_of(record))
    # An even part copies a share, so it has no number.
    node.channels[0] = math.nan if is_even else logit
    children = [
        _with_nodes(child, own, is_even=same)
        for child, own, same in zip(nested.children, logits, even, strict=True)
    ]
    node.children += [child.token for child in children]
    return Nested(record, node, children)


def _are_even(parts: Sequence[Record], logits: Sequence[float]) -> list[bool]:
    """Mark the parts of a side that copy the share of the last equal part before them."""
    last: dict[tuple[str, str], float] = {}
    found: list[bool] = []
    for part, logit in zip(parts, logits, strict=True):
        what = same_part(_kind(part))
        found.append(abs(logit - last.get(what, math.nan)) <= _SAME_LOGIT)
        if not math.isnan(logit):
            last[what] = logit
    return found


def _kind(record: Record, *, is_even: bool = False) -> Kind:
    said: dict[str, Any] = {"is_even": True} if is_even else {}
    # Words of objects are JSON arrays; other words are plain names.
    if record.kind.startswith("["):
        word = Word.read(record.kind)
        said["category"] = word.category
        if record.node != "width":
            said |= {"domain": word.domain, "attributes": word.attributes}
    elif record.node == "border":
        said["attributes"] = (("form", record.kind),) if record.kind else ()
    else:
        said["category"] = record.kind
    names = OF_RECORD[record.node]
    said |= {name: getattr(record, name) for name in names}
    said |= {name: int(said[name]) for name in FLAGS & names}
    return KINDS[record.node](**said)


def _add_borders(storey: StoreyPartition, records: list[Record], found: Cells) -> list[Node]:
    """Build the nodes of a storey's borders, each below the leaf of its room."""
    sequence = iter(records)
    # A border belongs to the first leaf of its room, which the decoder finds again.
    rooms = first_leaves(room_numbers(storey_cells(storey)))
    borders: list[Node] = []
    for line, border in zip(storey_lines(storey), storey.borders, strict=True):
        nested = nest(sequence)
        is_wall = [segment.kind for segment in border.segments] == ["wall"]
        if is_wall:
            nested.children.clear()
        node = _with_nodes(nested, math.nan).token
        owner, side, beyond = owner_of(line, rooms, len(found))
        # A border that is all open or all wall needs no segments.
        arity = 0 if is_wall else nested.record.arity
        category = "wall" if is_wall else "mixed" if arity else "open"
        node.kind = msgspec.structs.replace(node.kind, category=category, arity=arity, side=side)
        node.host = beyond
        borders.append(found[owner][0].add(node))
    return borders


def first_leaves(rooms: Sequence[int]) -> dict[int, int]:
    """Return the first leaf of each room, from the room of each leaf."""
    leaves: dict[int, int] = {}
    for leaf, room in enumerate(rooms):
        leaves.setdefault(room, leaf)
    return leaves


def owner_of(line: Line, rooms: dict[int, int], n_leaves: int) -> tuple[int, int, int]:
    """Return the leaf that owns a line, its side, and the number of leaves to the room beyond.

    The last is 0 if no room is beyond.
    """
    low, high = line.rooms
    if low == NOBODY:
        return rooms[high], SIDES[line.axis, False], 0
    # Counted onwards and around, so that the number is never negative.
    beyond = 0 if high == NOBODY else (rooms[high] - rooms[low]) % n_leaves
    return rooms[low], SIDES[line.axis, True], beyond
