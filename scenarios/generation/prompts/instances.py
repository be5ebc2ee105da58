"""Things of one name in a scene, each made of one object or of several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from jaxtyping import Bool, Float

from aeroscene.metrics.arrays import NO_PARENT
from aeroscene.metrics.places.top_view import TopView, union
from aeroscene.relations.hosts import level_m


@dataclass(frozen=True)
class Instances:
    """Things of one name in a scene, one row each."""

    view: TopView
    rows: tuple[tuple[int, ...], ...]
    """Rows of the objects of each thing: a single one, the tiles of a room, or a cluster."""

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def first(self) -> np.ndarray:
        """Row of the first object of each thing; its axes count as the thing's."""
        return np.array([rows[0] for rows in self.rows], dtype=int)

    @cached_property
    def outline(self) -> np.ndarray:
        """Outlines from above, as shapely polygons."""
        outlines = self.view.outline
        return np.array(
            [
                outlines[rows[0]] if len(rows) == 1 else union(outlines[list(rows)])
                for rows in self.rows
            ],
            dtype=object,
        )

    @cached_property
    def centre(self) -> np.ndarray:
        """Centroids as points."""
        return shapely.centroid(self.outline)

    @property
    def base_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the undersides."""
        return self._each(self.view.base_m, min)

    @property
    def top_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the upper sides."""
        return self._each(self.view.top_m, max)

    @property
    def level_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the surfaces to stand on: the tops, but of bridges the decks."""
        objects = self.view.scene.objects
        levels = np.array([level_m(obj.category, obj.bbox) for obj in objects])
        return self._each(levels, max)

    @property
    def bearer(self) -> np.ndarray:
        """Row of the parent of the first object; `NO_PARENT` without one."""
        return self.view.arrays.parent[self.first]

    def _each(self, values: np.ndarray, choose: Callable[[Sequence[float]], float]) -> np.ndarray:
        return np.array([choose([values[row] for row in rows]) for rows in self.rows], dtype=float)

    def chosen(self, keep: Bool[np.ndarray, " n"]) -> Instances:
        """Return the things that a mask keeps.

        Args:
            keep: True for each thing to keep.
        """
        return Instances(
            self.view, tuple(r for r, is_kept in zip(self.rows, keep, strict=True) if is_kept)
        )


def is_borne_by(things_: Instances, hosts: Instances) -> Bool[np.ndarray, "n k"]:
    """Return a table that is true if the parent of a thing is an object of a host.

    Args:
        things_: Things, n of them.
        hosts: Hosts, k of them.
    """
    bearer = things_.bearer
    table = np.zeros((len(things_), len(hosts)), dtype=bool)
    for k, rows in enumerate(hosts.rows):
        # A thing without a parent has no row to compare.
        table[:, k] = np.isin(bearer, rows) & (bearer != NO_PARENT)
    return table
