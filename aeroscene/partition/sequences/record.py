"""Trees as flat lists of small records in pre-order, which a model can learn one by one.

A record's discrete fields say what comes; its numbers say how large. A partition begins with the
widths that its strips share (doors and windows too), so that `strip` can name them.

    record         then come                              discrete           values
    width                                                                    metres
    site           tree                                                      frame, base
    storey         tree, borders to the end               is_inset           frame, level, walls,
                                                                             outer walls, drop
    leaf                                                                     height
    slice          children with a share or strip each    arity: children
    cross, grid    part per column and row, then cells    arity: columns,
                                                          rows
    pinwheel       arms, middle                           is_mirrored        west, east, south,
                                                                             north
    overlay        its leaf, items                        arity: items
    item           tree                                   is_placed          x, y, yaw, length,
                                                                             width, if placed
    bend           lanes, banks                           arity: pieces,     start, heading,
                                                          rows: lanes        lengths, turns
    lane                                                                     height per piece
    bank           tree, if placed                        is_placed          low, high, depth,
                                                                             if placed
    border         segments; no segment means open        arity: segments
    segment                                                                  sill, head

A frame has five values: x, y, yaw, length, width.
"""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.partition.sites.site import SitePartition
from aeroscene.partition.storeys.storey import StoreyPartition

Partition = SitePartition | StoreyPartition


@dataclass(frozen=True, slots=True)
class Record:
    """One symbol of a sequence with its numbers."""

    node: str
    """Node of the record, from the table."""
    axis: str = ""
    """Axis of a slice, `x` or `y`."""
    arity: int = 0
    rows: int = 0
    is_inset: bool = False
    is_mirrored: bool = False
    is_placed: bool = False
    kind: str = ""
    """Word of a leaf, lane or segment, or the form of a border's wall."""
    merge: int = 0
    quarter: int = 0
    strip: int = 0
    """Number of the width, from 1, that this has in its parent; 0 if it has a share."""
    share: float = 0.0
    values: tuple[float, ...] = ()
