"""Landing areas on the bare ground of a relief: on gentle, even ground and nowhere else."""

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.areas.needs import MAX_SLOPE_RAD
from aeroscene.scene import Relief
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
