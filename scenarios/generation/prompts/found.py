"""Where things of the vocabulary are in a scene: each by its heart, judged by geometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import shapely
from jaxtyping import Bool, Float
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from aeroscene.metrics.arrays import NO_PARENT
from aeroscene.metrics.places.top_view import TopView, near_pairs, union
from aeroscene.relations.hosts import level_m
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import ROOMS, by_name
from aeroscene.scene.rooms import NO_ROOM, tile_groups
from scenarios.generation.prompts.vocabulary import Part, Thing, things

_SAME_LEVEL_M = 0.5
"""Hearts farther apart in height are not in one cluster."""


@dataclass(frozen=True)
class Found:
    """Things of one name in a scene, one row each."""

    view: TopView
    rows: tuple[tuple[int, ...], ...]
    """Rows of the objects that each is made of: one, or the tiles of a room, or a cluster."""

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def first(self) -> np.ndarray:
        """Row of the first object of each, whose axes are the thing's."""
        return np.array([rows[0] for rows in self.rows], dtype=int)

    @cached_property
    def outline(self) -> np.ndarray:
        """Outlines from above."""
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
        """Heights of what one stands on: the tops, of bridges the decks between the rails."""
        objects = self.view.scene.objects
        levels = np.array([level_m(obj.category, obj.bbox) for obj in objects])
        return self._each(levels, max)

    @property
    def bearer(self) -> np.ndarray:
        """Row of the parent of the first object; `NO_PARENT` without one."""
        return self.view.arrays.parent[self.first]

    def _each(self, values: np.ndarray, choose: Callable[[Sequence[float]], float]) -> np.ndarray:
        return np.array([choose([values[row] for row in rows]) for rows in self.rows], dtype=float)

    def chosen(self, keep: Bool[np.ndarray, " n"]) -> Found:
        """Some of these."""
        return Found(
            self.view, tuple(r for r, is_kept in zip(self.rows, keep, strict=True) if is_kept)
        )


@dataclass
class Finder:
    """Finds things in one scene, each name once."""

    scene: Scene
    _found: dict[str, Found] = field(default_factory=dict)

    @cached_property
    def view(self) -> TopView:
        """The scene from above."""
        return TopView(self.scene)

    def found(self, name: str) -> Found:
        """All things of a name of the vocabulary."""
        if name not in self._found:
            self._found[name] = self._find(name, things()[name])
        return self._found[name]

    def _find(self, name: str, thing: Thing) -> Found:
        if thing.hearts:
            hearts = [rows for heart in thing.hearts for rows in self.found(heart).rows]
            found = Found(self.view, tuple(dict.fromkeys(hearts)))
        else:
            found = Found(self.view, self._of_category(name))
        found = found.chosen(
            np.array([self._is_such(rows[0], thing) for rows in found.rows], dtype=bool)
        )
        for part in thing.parts:
            found = found.chosen(self._has(found, part))
        if thing.cluster_m:
            found = _clusters(found, thing.cluster_m, thing.least)
        return found

    def _of_category(self, name: str) -> tuple[tuple[int, ...], ...]:
        """Objects of a category; the tiles of a room are one."""
        rows = self.view.rows({name}) if name in by_name() else ()
        if name not in ROOMS:
            return tuple((int(row),) for row in rows)
        groups = tile_groups(self.scene.objects)
        tiles: dict[int, list[int]] = {}
        for row in map(int, rows):
            tiles.setdefault(int(groups[row]) if groups[row] != NO_ROOM else -2 - row, []).append(
                row
            )
        return tuple(map(tuple, tiles.values()))

    def _is_such(self, row: int, thing: Thing) -> bool:
        """Whether a heart has the form, the use and the shape of a thing."""
        obj = self.scene.objects[row]
        if thing.form and obj.attributes.get("form") != thing.form:
            return False
        if thing.use and obj.attributes.get("use") not in thing.use:
            return False
        short_m, long_m = sorted(obj.bbox.s[:2])
        return long_m >= thing.long * short_m

    def _has(self, found: Found, part: Part) -> Bool[np.ndarray, " n"]:
        """Whether a part of a thing stands about each heart."""
        from scenarios.generation.prompts.relations import holds

        parts = self.found(part.thing)
        if not len(found) or not len(parts):
            return np.zeros(len(found), dtype=bool)
        return holds(part.relation, parts, found, part.within_m).sum(axis=0) >= part.least


def _clusters(found: Found, apart_m: float, least: int) -> Found:
    """Groups of things no farther apart than a distance, of at least so many."""
    if not len(found):
        return found
    first, second = near_pairs(found.outline, found.outline, apart_m)
    is_level = np.abs(found.base_m[first] - found.base_m[second]) <= _SAME_LEVEL_M
    first, second = first[is_level], second[is_level]
    links = coo_array((np.ones(len(first)), (first, second)), shape=(len(found), len(found)))
    n_groups, group = connected_components(links, directed=False)
    rows = [
        tuple(row for i in np.flatnonzero(group == g) for row in found.rows[i])
        for g in range(n_groups)
        if (group == g).sum() >= least
    ]
    return Found(found.view, tuple(rows))


def is_borne_by(things_: Found, hosts: Found) -> Bool[np.ndarray, "n k"]:
    """Whether the parent of each thing is an object of each host."""
    bearer = things_.bearer
    table = np.zeros((len(things_), len(hosts)), dtype=bool)
    for k, rows in enumerate(hosts.rows):
        table[:, k] = np.isin(bearer, rows) & (bearer != NO_PARENT)
    return table
