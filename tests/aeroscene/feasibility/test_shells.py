from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.feasibility.heights import set_heights
from aeroscene.feasibility.layout import Layout, layout_of
from aeroscene.feasibility.shells import fit_shells
from aeroscene.scene import Scene
from tests.aeroscene.feasibility.scenes import garden, thing

SHELL, SLAB, ROOM, WALL, ROOF = range(20, 25)


def bungalow(*changed) -> Layout:
    parts = {
        SHELL: thing(
            SHELL, "house", (0.0, 0.0, 1.71), (8.0, 10.0, 3.3), is_enterable=True, form="plain"
        ),
        SLAB: thing(SLAB, "floor", (0.0, 0.0, 0.135), (7.5, 9.5, 0.15), SHELL),
        ROOM: thing(ROOM, "room", (0.0, -2.4, 1.785), (7.5, 4.6, 3.15), SHELL),
        WALL: thing(WALL, "wall", (0.0, 0.0, 1.785), (0.12, 7.5, 3.15), SHELL, np.pi / 2),
        ROOF: thing(ROOF, "roof", (0.0, 0.0, 4.66), (8.8, 10.8, 2.6), SHELL, form="gable"),
    } | {obj.id: obj for obj in changed}
    scene: Scene = replace(garden(), objects=(garden().objects[0], *parts.values()))
    return layout_of(scene)


def row(layout: Layout, number: int) -> int:
    return [obj.id for obj in layout.objects].index(number)


def settled(layout: Layout) -> Layout:
    fit_shells(layout)
    set_heights(layout, np.arange(len(layout.objects)))
    return layout


def test_a_sound_building_stays_as_it_is():
    layout = bungalow()
    before = layout.boxes.copy()
    settled(layout)
    np.testing.assert_allclose(layout.boxes.half_m, before.half_m)
    house = slice(row(layout, SLAB), None)
    lifted = layout.boxes.centre_m - before.centre_m
    np.testing.assert_allclose(lifted[house, :2], 0.0)
    np.testing.assert_allclose(lifted[house, 2], lifted[row(layout, SHELL), 2], atol=1e-9)


def test_a_room_stands_on_the_slab_and_ends_below_the_roof():
    layout = settled(bungalow(thing(ROOM, "room", (0.0, -2.4, 2.0), (7.5, 4.6, 3.0), SHELL)))
    boxes, room = layout.boxes, row(layout, ROOM)
    assert boxes.base_m[room] == pytest.approx(boxes.top_m[row(layout, SLAB)])
    assert boxes.top_m[room] == pytest.approx(boxes.top_m[row(layout, SHELL)])


def test_a_shell_grows_to_hold_its_rooms():
    layout = settled(bungalow(thing(ROOM, "room", (0.3, -2.4, 1.785), (7.5, 4.6, 3.15), SHELL)))
    boxes, shell = layout.boxes, row(layout, SHELL)
    assert boxes.centre_m[shell, 0] + boxes.half_m[shell, 0] == pytest.approx(4.3)
    assert boxes.centre_m[shell, 0] - boxes.half_m[shell, 0] == pytest.approx(-4.0)


def test_a_roof_lies_evenly_over_its_building():
    layout = settled(
        bungalow(thing(ROOF, "roof", (0.25, 0.0, 5.5), (8.8, 10.8, 2.6), SHELL, form="gable"))
    )
    boxes, shell, roof = layout.boxes, row(layout, SHELL), row(layout, ROOF)
    np.testing.assert_allclose(boxes.centre_m[roof, :2], boxes.centre_m[shell, :2])
    assert (boxes.half_m[roof, :2] >= boxes.half_m[shell, :2]).all()
    assert boxes.base_m[roof] == pytest.approx(boxes.top_m[shell])
