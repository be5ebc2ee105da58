"""Mapped layouts, and draws of what has learnt them, come whole through the projection."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.feasibility import make_feasible
from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.stages import finished
from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.learning.program import decode, encode
from aeroscene.learning.program.decoding.cfg import DecodingCfg
from aeroscene.metrics.consistency import coarse_to_fine_consistency
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation.boxes import overlaps
from aeroscene.validation.support import floating
from tests.aeroscene.layouts.samples import box

CEILING_M = 3.02
"""Of a room without anything high, its floor's finish included."""

RECORD = {
    "scene_id": "made-up/angle",
    "domain": "indoor",
    "floor": [[0, 0], [6, 0], [6, 3], [3.5, 3], [3.5, 6], [0, 6]],
    "objects": [
        box("King-size Bed", (1.1, 3.2, 0.5), (1.8, 2.1, 1.0), 90),
        box("Ceiling Lamp", (4.5, 1.5, 2.5), (0.5, 0.5, 0.2)),
        box("Wardrobe", (5.6, 1.0, 1.0), (1.4, 0.6, 2.0), 90),
    ],
    "attributes": {"room_type": "bedroom"},
}


@pytest.fixture(scope="module")
def scene():
    """A room in the form of an L, whose bed stands on two of its tiles."""
    return make_flyable(neutral_layout(RECORD))[0]


def one(scene, category):
    (found,) = (obj for obj in scene.objects if obj.category == category)
    return found


def test_a_lamp_hangs_from_the_ceiling_and_floats_nowhere(scene):
    lamp = one(scene, "lamp")
    assert lamp.bbox.p[2] + lamp.bbox.s[2] / 2 == pytest.approx(CEILING_M)
    assert lamp.bbox.p[2] - lamp.bbox.s[2] / 2 == pytest.approx(2.42)
    assert not list(floating(scene, colliding(scene_primitives(scene))))
    lower = replace(lamp, bbox=replace(lamp.bbox, p=(*lamp.bbox.p[:2], lamp.bbox.p[2] - 0.1)))
    fallen = replace(scene, objects=tuple(lower if obj is lamp else obj for obj in scene.objects))
    (finding,) = floating(fallen, colliding(scene_primitives(fallen)))
    assert finding.object_id == lamp.id
    mended = one(make_feasible(fallen).scene, "lamp")
    assert mended.bbox.p == pytest.approx(lamp.bbox.p, abs=1e-3)


def test_what_stands_on_two_tiles_of_a_room_stays(scene):
    tiles = [obj for obj in scene.objects if obj.category == "room"]
    assert len(tiles) == 2
    assert not list(overlaps(scene))
    found = make_feasible(scene)
    assert found.report.rejection is None
    kept = found.scene.object_by_id
    for obj in scene.objects:
        assert kept[obj.id].bbox.p == pytest.approx(obj.bbox.p, abs=0.02)
    # As a tile of another room it would be in the bed's way.
    other = replace(tiles[1], attributes=tiles[1].attributes | {"room": 1})
    parted = replace(
        scene, objects=tuple(other if obj is tiles[1] else obj for obj in scene.objects)
    )
    assert [finding.kind for finding in overlaps(parted)] == ["overlap"]


def test_a_roof_lies_on_its_house_wherever_it_was_drawn(scene):
    roofs = [obj for obj in scene.objects if obj.category == "roof"]
    encoded = encode(scene)
    channels = encoded.program.channels.copy()
    tokens = [
        number for number, kind in enumerate(encoded.program.kinds) if kind.category == "roof"
    ]
    channels[tokens] += np.random.default_rng(0).normal(0.0, 0.3, channels[tokens].shape)
    made = decode(replace(encoded.program, channels=channels)).scene
    found = [obj for obj in made.objects if obj.category == "roof"]
    assert len(found) == len(roofs)
    for roof in roofs:
        away_m = [np.abs(np.subtract(obj.bbox.p, roof.bbox.p))[:2].max() for obj in found]
        assert min(away_m) < 0.02
    assert {round(obj.bbox.p[2] - obj.bbox.s[2] / 2, 3) for obj in found} == {CEILING_M}


def test_a_roof_beside_its_rooms_does_not_fall_into_them(scene):
    """It covers most of no room, and most of no wall."""
    low = min(
        (obj for obj in scene.objects if obj.category == "roof"), key=lambda obj: obj.bbox.p[1]
    )
    x, y, z = low.bbox.p
    beside = replace(low, bbox=replace(low.bbox, p=(x + 5.9, y + 2.85, z)))
    objects = tuple(beside if obj is low else obj for obj in scene.objects)
    found = make_feasible(replace(scene, objects=objects, interaction_areas=()))
    kept = found.scene.object_by_id
    for obj in scene.objects:
        # The lamp hung from it.
        if obj.category not in {"roof", "lamp"}:
            assert kept[obj.id].bbox.p == pytest.approx(obj.bbox.p, abs=0.02)


def changed(scene, change):
    """A scene whose boxes are others, without areas."""
    objects = tuple(replace(obj, bbox=change(obj)) for obj in scene.objects)
    return replace(scene, objects=objects, interaction_areas=())


def test_a_yard_ends_at_its_house_and_no_wall_makes_room_for_it(scene):
    """Lawns that reach 0.3 m too far in, under the walls, are cut."""
    boxes = [obj.bbox for obj in scene.objects if obj.category == "room"]
    middle = np.mean([box.p[:2] for box in boxes], axis=0)

    def nearer(obj):
        x, y, z = obj.bbox.p
        if obj.category != "lawn":
            return obj.bbox
        away = np.array([x, y]) - middle
        step = 0.3 * np.sign(away) * (np.abs(away) == np.abs(away).max())
        return replace(obj.bbox, p=(x - step[0], y - step[1], z))

    drawn = changed(scene, nearer)
    found = make_feasible(drawn).scene.object_by_id
    assert sum(found[o.id].bbox.s != o.bbox.s for o in drawn.objects if o.category == "lawn") >= 3
    for obj in drawn.objects:
        if obj.category in {"room", "wall"}:
            assert found[obj.id].bbox.p == pytest.approx(obj.bbox.p, abs=1e-3)


def test_rooms_and_walls_under_one_roof_have_one_ceiling(scene):
    """A tile of the room that was drawn 5% higher."""
    program = encode(scene).program
    channels = program.channels.copy()
    leaves = [
        number
        for number, kind in enumerate(program.kinds)
        if (kind.node, kind.category) == ("leaf", "room")
    ]
    channels[leaves[0], 1] += np.log(1.05)
    made = decode(replace(program, channels=channels)).scene
    tops_m = {
        round(obj.bbox.p[2] + obj.bbox.s[2] / 2, 3)
        for obj in made.objects
        if obj.category in {"room", "wall"}
    }
    assert tops_m == {CEILING_M}


def test_what_stands_in_another_tile_than_its_own_belongs_to_that_one(scene):
    tiles = [obj for obj in scene.objects if obj.category == "room"]
    wardrobe = one(scene, "wardrobe")
    (far,) = (tile for tile in tiles if tile.id != wardrobe.parent_id)
    strayed = replace(wardrobe, parent_id=far.id)
    wrong = replace(scene, objects=tuple(strayed if o is wardrobe else o for o in scene.objects))
    projected = finished(layout_of(wrong))
    assert projected.object_by_id[wardrobe.id].parent_id == wardrobe.parent_id


def test_what_is_drawn_beside_something_belongs_to_the_tile_that_it_is_in(scene):
    bed = one(scene, "bed")
    (near,) = (o for o in scene.objects if o.category == "room" and o.id != bed.parent_id)
    stand = box("Nightstand", (1.1, 1.95, 0.25), (0.5, 0.4, 0.5), 180)
    record = RECORD | {"objects": [*RECORD["objects"], stand]}
    whole = make_flyable(neutral_layout(record))[0]
    beside = one(whole, "nightstand")
    assert beside.parent_id == near.id
    strayed = replace(beside, parent_id=bed.parent_id)
    wrong = replace(whole, objects=tuple(strayed if o is beside else o for o in whole.objects))
    assert coarse_to_fine_consistency(wrong).border > 0.0
    drawn = decode(encode(wrong).program, cfg=DecodingCfg(makes_room=False)).scene
    assert one(drawn, "nightstand").bbox.p == pytest.approx(beside.bbox.p, abs=1e-3)
    assert coarse_to_fine_consistency(drawn).border == 0.0
