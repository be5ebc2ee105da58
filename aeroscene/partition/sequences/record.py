"""Trees as flat lists of small records in pre-order, and back without loss: what a model embeds.

A record's discrete fields say what comes; its numbers say how large. A partition begins with the
widths that its strips share (doors and windows too), so that `strip` can name them.

| record | then come | discrete | values |
|---|---|---|---|
| `width` | | | metres |
| `site` | tree | | frame (x, y, yaw, length, width), base |
| `storey` | tree, borders to the end | `is_inset` | frame, level, walls, outer walls, drop |
| `leaf` | | | height |
| `slice` | children, each with its `share` or `strip` | `arity` children | |
| `cross`, `grid` | `part` for each column and row, cells | `arity` columns, `rows` | |
| `pinwheel` | arms, middle | `is_mirrored` | west, east, south, north |
| `overlay` | its leaf, items | `arity` items | |
| `item` | tree | `is_placed` | x, y, yaw, length, width, if it is placed |
| `bend` | lanes, banks | `arity` pieces, `rows` lanes | start, heading, lengths, turns |
| `lane` | | | a height for each piece |
| `bank` | tree, if it is placed | `is_placed` | low, high, depth, if it is placed |
| `border` | segments; none is open | `arity` segments | |
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
    is_inset: bool = False
    is_mirrored: bool = False
    is_placed: bool = False
    kind: str = ""
    merge: int = 0
    quarter: int = 0
    strip: int = 0
    """Number of the width, from 1, that this has in its parent; 0 where it has a share."""
    share: float = 0.0
    values: tuple[float, ...] = ()
