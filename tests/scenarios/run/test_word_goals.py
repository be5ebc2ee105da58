"""Flights to goals in words: what the pilot is told, and which landings count."""

from dataclasses import replace

import pytest

from aeroscene.corpus.field import field_scene
from flightsim.testbench import TestbenchCfg, TestbenchError
from flightsim.vehicles import airframe_by_name
from scenarios.baselines.straight_line import StraightLinePilot
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from scenarios.trials.verdict import Code, Fate, Verdict
from scenarios.words.goal_choice import WordsError, choose_goal

QUICK = TestbenchCfg(speed="max")
PAD = field_scene().interaction_areas[0]


def on_lawn(number, x, y):
    """An area of the lawn, 2 m wide."""
    z = 0.1
    corners = ((x - 1, y - 1, z), (x + 1, y - 1, z), (x + 1, y + 1, z), (x - 1, y + 1, z))
    return replace(PAD, id=number, object_id=0, polygon=corners, centroid=(x, y, z), radius=1.0)


NEAR, FAR = on_lawn(1, 4.0, -3.0), on_lawn(2, -4.0, 3.0)
SCENE = replace(field_scene(), interaction_areas=(PAD, NEAR, FAR))


class Listener:
    """Stays on the ground for six seconds and keeps what it is told."""

    area = None
    is_done = False
    verdict = Verdict(success=True, reason="listened")

    def __init__(self, aboard):
        self.aboard, self.client = aboard, aboard.client

    def update(self, time_us):
        self.client.update(time_us)
        self.is_done = time_us > 6_000_000


def listen(area=NEAR, seed=0, **more):
    bench = replace(QUICK, seed=seed)
    cfg = SitlCfg(goal="naming", area=area.id, bench=bench, **more)
    with Sitl(cfg, scene=SCENE, pilot=Listener, has_network=False) as sitl:
        sitl.run()
        return sitl, sitl.flights[0].companion


def test_the_text_comes_with_the_equipment_and_over_mavlink_and_the_area_does_not():
    # Longer than one message.
    sitl, listener = listen(PAD, seed=2)
    text = sitl.words.text
    assert "the landing pad with red and white rings" in text
    assert len(text) > 50
    assert (listener.aboard.text, listener.aboard.area) == (text, None)
    assert listener.aboard.scene.interaction_areas
    heard = [said for _, said in listener.client.telemetry.texts if said.startswith("Goal: ")]
    assert set(heard) == {f"Goal: {text}"}


def test_without_a_map_neither_objects_nor_areas_are_given():
    _, listener = listen(map="onboard")
    assert listener.aboard.scene.objects == ()
    assert listener.aboard.scene.interaction_areas == ()
    assert listener.aboard.insight is None


def land_on(area):
    cfg = SitlCfg(goal="naming", area=NEAR.id, bench=QUICK)

    def make(aboard):
        return StraightLinePilot(replace(aboard, area=area))

    with Sitl(cfg, scene=SCENE, pilot=make, has_network=False) as sitl:
        return sitl.run()


def test_any_area_of_the_place_will_do():
    result = land_on(FAR)
    assert (result.code, result.landed_area, result.area) == (Code.LANDED, FAR.id, FAR.id)
    assert (result.goal, result.navigation_error_m < 0.3) == ("naming", True)


def test_another_place_will_not():
    result = land_on(PAD)
    assert (result.code, result.landed_area) == (Code.ALTERNATE, PAD.id)
    assert result.fate is Fate.SAFE_DOWN
    x, y, _ = PAD.centroid
    assert result.navigation_error_m == pytest.approx(
        ((x - 5.0) ** 2 + (y + 2.0) ** 2) ** 0.5, abs=0.3
    )
    assert result.oracle_error_m < 3.7 < result.navigation_error_m
    assert result.path_m > 20.0


def test_a_scene_without_a_text_is_refused():
    scene = replace(SCENE, objects=SCENE.objects[:1], interaction_areas=(NEAR,))
    iris = airframe_by_name("iris")
    with pytest.raises(WordsError, match=r"goal chain: scene field has no text.*valid: another"):
        choose_goal(scene, iris, asked="chain", seed=0)


def test_a_goal_in_words_is_one_vehicles():
    with pytest.raises(TestbenchError, match="goal 'words' is one vehicle's"):
        SitlCfg(goal="words", vehicles="2")
