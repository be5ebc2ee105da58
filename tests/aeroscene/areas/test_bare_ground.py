"""Landing areas on the bare ground of a relief: on gentle, even ground and nowhere else."""

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.areas.needs import MAX_SLOPE_RAD
from aeroscene.areas.start import grounds_of
from aeroscene.scene import OrientedBox, Relief, SceneObject
from aeroscene.scene.catalogue import category_id
from aeroscene.sources import load_scene
from aeroscene.validation import validate
from tests.flightsim.handmade import incline, relief_scene


def areas_at(slope_deg):
    gradient = math.tan(math.radians(slope_deg))
    scene = relief_scene(incline(0.6 * gradient, -0.8 * gradient))
    return replace(scene, interaction_areas=derive_interaction_areas(scene))


@pytest.mark.parametrize("slope_deg", [0.0, 5.0, 9.9])
def test_a_gentle_slope_bears_areas_that_hold_what_they_claim(slope_deg):
    scene = areas_at(slope_deg)
    assert len(scene.landing_areas) > 10
    for area in scene.landing_areas:
        assert area.object_id is None
        assert math.degrees(area.slope_rad) == pytest.approx(slope_deg, abs=0.01)
    assert validate(scene) == ()


def test_a_slope_beyond_the_limit_bears_none():
    assert areas_at(10.2).interaction_areas == ()


def test_of_a_terraced_hillside_only_the_terraces_bear_areas():
    line = np.arange(-40.0, 40.5, 1.0)
    steps_m = 3.0 * np.floor(line / 16.0) + np.clip(3.0 * (line % 16.0 - 13.0) / 3.0, 0.0, 3.0)
    relief = Relief((-40.0, -40.0), 1.0, np.tile(steps_m, (len(line), 1)))
    scene = relief_scene(relief, start_xy=(6.0, 0.0))
    areas = derive_interaction_areas(scene)
    assert len(areas) > 10
    assert {area.slope_rad for area in areas} == {0.0}
    for area in areas:
        assert area.centroid[0] % 16.0 + area.radius <= 13.01
    assert validate(replace(scene, interaction_areas=areas)) == ()


def test_an_object_that_the_ground_buries_bears_no_area():
    scene = load_scene("hills")
    pad = scene.objects[1]
    assert any(area.object_id == pad.id for area in scene.interaction_areas)
    x, y, z = pad.bbox.p
    sunk = replace(pad, bbox=replace(pad.bbox, p=(x, y, z - 0.08)))
    objects = tuple(sunk if obj.id == pad.id else obj for obj in scene.objects)
    areas = derive_interaction_areas(replace(scene, objects=objects, interaction_areas=()))
    assert all(area.object_id != pad.id for area in areas)


def test_the_scene_hills_is_sound_and_has_areas_on_its_slopes():
    scene = load_scene("hills")
    assert validate(scene) == ()
    slopes = [area.slope_rad for area in scene.landing_areas if area.object_id is None]
    assert len(slopes) > 20
    assert math.radians(5.0) < max(slopes) <= MAX_SLOPE_RAD


def test_areas_that_lie_about_the_ground_are_found_out():
    scene = areas_at(5.0)
    x, y, z = scene.landing_areas[0].centroid
    area = scene.landing_areas[0]

    def moved(up_m):
        polygon = tuple((u, v, w + up_m) for u, v, w in area.polygon)
        wrong = replace(area, centroid=(x, y, z + up_m), polygon=polygon)
        found = validate(replace(scene, interaction_areas=(wrong,)))
        return " ".join(finding.detail for finding in found)

    assert "the ground has no face there" in moved(0.1)
    assert "the ground rises 0.20 m above its plane" in moved(-0.2)


def covered(*objects):
    """A scene whose eastern half is a hill of half a metre, with objects on it."""
    heights = np.zeros((81, 81))
    heights[:, 44:] = 0.5
    scene = relief_scene(Relief((-40.0, -40.0), 1.0, heights), start_xy=(-5.0, 0.0))
    return replace(scene, objects=objects)


def lawn(top_m):
    return SceneObject(
        id=0,
        scene_id="relief",
        parent_id=None,
        category_id=category_id("lawn"),
        bbox=OrientedBox((0.0, 0.0, top_m / 2), (1.0, 0.0, 0.0, 0.0), (40.0, 40.0, top_m)),
        domain="outdoor",
    )


def test_a_lawn_bears_areas_where_the_land_does_not_come_through_it():
    scene = covered(lawn(0.1))
    areas = derive_interaction_areas(scene)
    on_lawn, on_land = (
        [area for area in areas if area.object_id == bearer] for bearer in (0, None)
    )
    assert len(on_lawn) > 2
    assert all(area.centroid[0] + area.radius <= 3.01 for area in on_lawn)
    # The ground below the lawn is no place to land.
    inside = [area for area in on_land if max(map(abs, area.centroid[:2])) < 20.0]
    assert len(inside) > 2
    assert all(area.centroid[0] - area.radius > 3.0 for area in inside)
    assert all(area.centroid[2] == 0.5 for area in inside)
    assert validate(replace(scene, interaction_areas=areas)) == ()


def test_a_flight_does_not_start_from_a_lawn_below_the_land():
    (ground, *_), *_ = grounds_of(covered(lawn(0.1)))
    x0, _, x1, _ = ground.outline.bounds
    assert (x0, x1) == (-20.0, 3.0)
    flat, *_ = grounds_of(replace(covered(lawn(0.1)), relief=None))[0]
    assert flat.outline.bounds == (-20.0, -20.0, 20.0, 20.0)


def test_ground_below_a_lawn_takes_no_place_from_land_beside_it():
    scene = covered(lawn(0.1))
    heights = np.zeros((81, 81))
    heights[:, 44:52] = 0.5
    scene = replace(scene, relief=Relief((-40.0, -40.0), 1.0, heights))
    middles = [a.centroid for a in derive_interaction_areas(scene) if a.object_id is None]
    on_land = [(x, y) for x, y, z in middles if z == 0.5 and abs(y) < 20.0]
    assert len(on_land) >= 3
