"""The partition of a site, and the covers that it makes."""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.partition.cells import cells_of, merged_from
from aeroscene.partition.frames import Frame
from aeroscene.partition.tree import Node
from aeroscene.scene import OrientedBox


@dataclass(frozen=True, slots=True, kw_only=True)
class SitePartition:
    """Division of the ground of a site."""

    frame: Frame
    tree: Node
    base_m: float = 0.0
    """Height of the bare ground."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cover:
    """A cover of the ground to place."""

    kind: str
    box: OrientedBox
    leaf: int
    """Number of its cell, see `aeroscene.partition.cells.cells_of`; the first of several."""


def build_site(site: SitePartition) -> list[Cover]:
    """Return the covers of a site in pre-order: side by side, or stacked on each other.

    Raises:
        PartitionError: If strips are wider than their frame.
    """
    # Leaves of one number are one cover again, as the site had it.
    cells = merged_from(list(cells_of(site.tree, site.frame, site.base_m)))
    return [
        Cover(kind=c.leaf.kind, box=c.frame.box(c.leaf.quarter, c.base_m, c.top_m), leaf=leaf)
        for leaf, c in cells
    ]
