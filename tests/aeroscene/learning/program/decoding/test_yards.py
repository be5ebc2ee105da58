"""The yard of a house ends at its walls, whatever numbers were drawn for either."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.learning.program import encode
from aeroscene.learning.program.decoding.decode import decode
from aeroscene.learning.program.decoding.draft.supports import _polygon
from aeroscene.relations.plane import footprint
from tests.aeroscene.layouts.samples import house


def house_with_a_corner():
    """Two rooms of which one is less deep, so that the yard has a tile in the corner."""
    record = house()
    rooms = record["attributes"]["rooms"]
    rooms[1]["polygon"] = [[0, -3], [5, -3], [5, 1], [0, 1]]
    record["floor"] = [[-5, -3], [5, -3], [5, 1], [0, 1], [0, 3], [-5, 3]]
    record["objects"] = record["objects"][:2]
    scene, _ = make_flyable(neutral_layout(record))
    return scene


def outlines(scene, *categories):
    return [_polygon(footprint(obj.bbox)) for obj in scene.objects if obj.category in categories]


HOUSE = house_with_a_corner()


def drawn(rng, spread, scene=HOUSE):
    """The same with the shares of the yard's tiles off by a spread of their logits."""
    program = encode(scene).program
    channels = program.channels.copy()
    site = next(i for i, kind in enumerate(program.kinds) if kind.node == "site")
    below = [i for i in range(len(program)) if i != site and within(program, i, site)]
    channels[below, 0] += rng.normal(0.0, spread, len(below))
    return decode(program.with_channels(channels)).scene


def within(program, place, above):
    while place > 0 and place != above:
        place = int(program.parent[place])
    return place == above


@pytest.mark.parametrize("seed", range(4))
def test_a_yard_ends_at_the_walls_and_leaves_nothing_bare(seed):
    scene = drawn(np.random.default_rng(seed), 0.4)
    lawns = shapely.union_all(outlines(scene, "lawn"))
    walled = shapely.union_all(outlines(scene, "wall", "room"))
    assert lawns.intersection(walled).area < 0.01
    whole = shapely.union_all([lawns, walled])
    assert whole.area == pytest.approx(whole.envelope.area, rel=1e-3)


def test_a_yard_as_it_was_read_stays():
    again = drawn(np.random.default_rng(0), 0.0)
    found, meant = (
        sorted(np.round(lawn.bounds, 2).tolist() for lawn in outlines(scene, "lawn"))
        for scene in (again, HOUSE)
    )
    assert found == meant


def test_a_yard_with_something_on_it_is_left_alone():
    lawn = next(obj for obj in HOUSE.objects if obj.category == "lawn")
    x, y, _ = lawn.bbox.p
    bench = replace(
        lawn,
        id=900,
        parent_id=lawn.id,
        category_id=next(o.category_id for o in HOUSE.objects if o.category == "table"),
        bbox=replace(lawn.bbox, p=(x, y, 0.4), s=(1.0, 1.0, 0.75)),
        domain="outdoor",
    )
    scene = drawn(np.random.default_rng(1), 0.4, replace(HOUSE, objects=(*HOUSE.objects, bench)))
    lawns, walled = (
        shapely.union_all(outlines(scene, *names)) for names in (("lawn",), ("wall", "room"))
    )
    assert lawns.intersection(walled).area > 0.1
