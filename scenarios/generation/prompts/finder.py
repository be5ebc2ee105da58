"""Finder of things of the vocabulary in a scene, by their hearts and by geometry.

A prompt speaks of a cafe or a marina, but scenes have categories such as kiosk, table and boat.
`things.toml` therefore defines each thing by a heart, an object of some categories, and by parts
that must stand about the heart, or by a cluster of several hearts. Geometry decides instead of a
label, so that a cafe counts in any scene, whoever made it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import ROOMS, by_name
from aeroscene.scene.rooms import NO_ROOM, tile_groups
from scenarios.generation.prompts.instances import Instances
from scenarios.generation.prompts.relations import holds, within
from scenarios.generation.prompts.vocabulary import Part, Thing, things

_SAME_LEVEL_M = 0.5
"""Greatest difference of heights within one cluster."""


@dataclass
class Finder:
    """Finds things in one scene, and keeps the result of each name."""

    scene: Scene
    _instances: dict[str, Instances] = field(default_factory=dict)

    @cached_property
    def view(self) -> TopView:
        """Outlines and heights of the scene's objects, seen from above."""
        return TopView(self.scene)

    def instances(self, name: str) -> Instances:
        """Return all things of a name.

        Args:
            name: Name of the vocabulary.

        Raises:
            KeyError: If the vocabulary has no such name.
        """
        if name not in self._instances:
            self._instances[name] = self._find(name, things()[name])
        return self._instances[name]

    def _find(self, name: str, thing: Thing) -> Instances:
        if thing.hearts:
            hearts = [rows for heart in thing.hearts for rows in self.instances(heart).rows]
            # An object that is the heart by two names counts once.
            found = Instances(self.view, tuple(dict.fromkeys(hearts)))
        else:
            found = Instances(self.view, self._of_category(name))
        found = found.chosen(
            np.array([self._is_such(rows[0], thing) for rows in found.rows], dtype=bool)
        )
        for part in thing.parts:
            found = found.chosen(self._has(found, part))
        if thing.cluster_m:
            found = _clusters(found, thing.cluster_m, thing.least)
        return found

    def _of_category(self, name: str) -> tuple[tuple[int, ...], ...]:
        """Return the rows of objects of a category, those of a room's tiles as one thing."""
        rows = self.view.rows({name}) if name in by_name() else ()
        if name not in ROOMS:
            return tuple((int(row),) for row in rows)
        groups = tile_groups(self.scene.objects)
        tiles: dict[int, list[int]] = {}
        for row in map(int, rows):
            # A tile without a room is a thing of its own: below -1, its key meets no group's.
            tiles.setdefault(int(groups[row]) if groups[row] != NO_ROOM else -2 - row, []).append(
                row
            )
        return tuple(map(tuple, tiles.values()))

    def _is_such(self, row: int, thing: Thing) -> bool:
        """Return true if a heart has the form, the use and the shape of a thing."""
        obj = self.scene.objects[row]
        if thing.form and obj.attributes.get("form") != thing.form:
            return False
        if thing.use and obj.attributes.get("use") not in thing.use:
            return False
        short_m, long_m = sorted(obj.bbox.s[:2])
        return long_m >= max(thing.long * short_m, thing.least_m)

    def _has(self, found: Instances, part: Part) -> Bool[np.ndarray, " n"]:
        """Return, for each heart, true if enough of a part stand about it."""
        parts = self.instances(part.thing)
        if part.relation is None:
            table = within(parts, found, part.within_m)
        else:
            table = holds(part.relation, parts, found)
        return table.sum(axis=0) >= part.least


def _clusters(found: Instances, apart_m: float, least: int) -> Instances:
    """Return groups of at least `least` things that are linked by gaps of at most `apart_m`."""
    if not len(found):
        return found
    # Connected components of the graph of near pairs: a long row is one cluster.
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
    return Instances(found.view, tuple(rows))
