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

from dataclasses import dataclass

from aeroscene.partition.sites.site import SitePartition
from aeroscene.partition.storeys.storey import StoreyPartition

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
