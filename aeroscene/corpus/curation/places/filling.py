"""What a place still has room for when all that makes it what it is stands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from aeroscene.corpus.curation.places.ground import Ground

_TURNED = frozenset(("bin", "planter", "pallet", "bench", "table"))
"""What people set square to the street."""


def fill_up(
    ground: Ground, names: Sequence[str], near: tuple[float, float, float, float], rounds: int
) -> Iterator[None]:
    """Two of a kind a step at free places of an area (u0, u1, v0, v1), the kinds in turn."""
    if near[1] - near[0] < 2.0 or near[3] - near[2] < 2.0:
        return
    for index in range(rounds):
        name = names[index % len(names)]
        if name == "tree":
            ground.plant_trees(2, near)
        else:
            ground.scatter(name, 2, near=near, turn=0.0 if name in _TURNED else None)
        yield
