"""Numbers of the things and relations of a prompt in a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from aeroscene.scene import Scene
from scenarios.generation.prompts.finder import Finder
from scenarios.generation.prompts.relations import between, holds
from scenarios.generation.prompts.wishes import Count, Relation


def numbers_of(scene: Scene, demands: Sequence[Count]) -> Iterator[tuple[Count, int]]:
    """Yield each count and relation with the number that a scene has.

    Args:
        scene: Scene to measure.
        demands: Counts and relations, whose names must be in the vocabulary.
    """
    # One finder for all, because it keeps what it has found by name.
    finder = Finder(scene)
    for demand in demands:
        yield demand, _number(finder, demand)


def _number(finder: Finder, demand: Count) -> int:
    subjects = finder.instances(demand.thing)
    if not isinstance(demand, Relation):
        return len(subjects)
    hosts = finder.instances(demand.host)
    if demand.relation == "between":
        return int(between(subjects, hosts, finder.instances(demand.other or demand.host)).sum())
    # A subject counts once, however many hosts it stands in the relation to.
    return int(np.any(holds(demand.relation, subjects, hosts), axis=1).sum())
