"""The pilot in the whole stack: it lands, it gives up what is unsafe, it says why it failed."""

import dataclasses
import math

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.client.client import MavlinkClient
from scenarios.pilot import Phase, Pilot, landing_phases
from scenarios.pilot.landing_phases import MAX_SEARCH_FRAMES, SEARCH_FRAMES
from tests.scenarios.landing_scenes import CONTAINER, ON_CONTAINER, ON_LAWN, thing, yard


def test_it_lands_on_the_container_and_disarms_phase_by_phase(demo):
    demo = demo(yard())
    pilot = demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert demo.targets() == [
        Phase.PREPARE,
        Phase.ARM,
        Phase.TAKEOFF,
        Phase.NAVIGATE,
        Phase.SEARCH,
        Phase.DESCEND,
        Phase.TOUCHDOWN,
        Phase.DISARM,
        Phase.DONE,
    ]
    assert all(change.reason for change in pilot.transitions)
    assert not demo.bench.autopilot.is_armed
    score = demo.score()
    assert score.contacts_before_touchdown == 0
    assert score.landed_area == demo.pilot.area.id
    assert score.touchdown_error_m < 0.3
    assert pilot.verdict.touchdown_error_m < 0.15
    assert pilot.landing_map.is_safe.any()


def test_an_area_that_is_full_of_crates_is_given_up_for_the_next(demo):
    demo = demo(yard(has_crates_on_top=True), known=yard(), alternates=[ON_LAWN])
    pilot = demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert pilot.area is ON_LAWN
    given_up = next(c for c in pilot.transitions if "on to area 1" in c.reason)
    assert given_up.source is Phase.SEARCH
    assert "no safe place seen on area 0" in given_up.reason
    looks = [change.reason for change in pilot.transitions if "looks from" in change.reason]
    assert [reason.split("; ")[1] for reason in looks] == ["looks from 2.0 m"]
    assert demo.score().landed_area == demo.pilot.area.id


def test_with_no_area_left_it_flies_home_lands_there_and_says_why(demo):
    demo = demo(yard(has_crates_on_top=True), known=yard())
    pilot = demo.fly()
    assert not pilot.verdict.success
    assert pilot.verdict.reason == "no safe place seen on area 0"
    assert demo.targets()[-4:] == [Phase.RETURN, Phase.LAND_HOME, Phase.DISARM, Phase.FAILED]
    assert not demo.bench.autopilot.is_armed
    assert math.dist(demo.bench.plant.truth.position_enu_m[:2], (0.0, 0.0)) < 0.3
    assert demo.score().contacts_before_touchdown <= 1


@pytest.mark.parametrize(("sway_m", "is_long"), [(0.0, False), (9.0, True)])
def test_a_place_with_less_room_than_gusts_take_is_looked_for_longer(demo, sway_m, is_long):
    demo = demo(yard())
    watch = demo.fly_to(Phase.SEARCH)._flight.watch
    watch.sway_m = sway_m
    demo.fly_to(Phase.DESCEND)
    assert watch.n_frames >= SEARCH_FRAMES
    assert (watch.n_frames >= MAX_SEARCH_FRAMES) == is_long


def test_how_far_gusts_carry_it_while_it_searches_is_noticed(demo):
    demo = demo(yard())
    pilot = demo.fly_to(Phase.SEARCH)
    watch = pilot._flight.watch
    demo.fly(until=lambda: pilot._flight.has_arrived)
    demo.bench.plant.data.qfrc_applied[1] = 15.0
    demo.fly(until=lambda: demo.deviation_m() > 0.3)
    demo.bench.plant.data.qfrc_applied[1] = 0.0
    demo.fly_to(Phase.DESCEND)
    assert watch.sway_m > 0.3


def test_a_place_that_no_steep_line_leads_to_is_flown_to_on_the_level_first(demo, monkeypatch):
    monkeypatch.setattr(landing_phases, "STEEP", 1000.0)
    crate = thing(90, "crate", (*ON_CONTAINER.centroid[:2], 3.2), (0.5, 0.5, 0.4), CONTAINER)
    demo = demo(dataclasses.replace(yard(), objects=(*yard().objects, crate)), known=yard())
    pilot = demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert demo.targets()[4:7] == [Phase.SEARCH, Phase.ALIGN, Phase.DESCEND]


def test_it_starts_again_from_the_top_when_the_place_turns_bad_on_the_way_down(demo):
    demo = demo(yard())
    pilot = demo.fly_to(Phase.DESCEND)
    # For a while the camera sees a step of half a metre in what was level before.
    render = demo.cameras.render_depth

    def with_a_step(camera):
        frame = render(camera)
        depth = frame.depth_m.copy()
        depth[:, 150:] -= 0.5
        return dataclasses.replace(frame, depth_m=depth)

    demo.see = with_a_step
    demo.fly_to(Phase.CLIMB)
    assert any("no longer looks safe" in change.reason for change in pilot.transitions)
    demo.see = render
    demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert demo.targets().count(Phase.SEARCH) == 2


def test_a_vehicle_that_is_switched_off_in_the_air_ends_the_flight(demo):
    demo = demo(yard())
    pilot = demo.fly_to(Phase.NAVIGATE)
    demo.bench.autopilot.disarm(is_forced=True)
    demo.fly()
    assert pilot.phase is Phase.FAILED
    assert pilot.verdict.reason.startswith("disarmed in phase navigate")


def test_somebody_who_takes_over_is_let_to(demo):
    demo = demo(yard())
    pilot = demo.fly_to(Phase.NAVIGATE)
    demo.bench.autopilot.set_mode(Mode.HOLD)
    demo.fly()
    assert pilot.phase is Phase.FAILED
    assert pilot.verdict.reason.startswith("the autopilot left offboard mode")
    assert demo.bench.autopilot.mode is Mode.HOLD


def test_a_link_without_a_vehicle_is_given_up_in_time(demo):
    class SilentPipe:
        def send(self, data):
            pass

        def recv(self):
            return b""

    demo = demo(yard())
    client = MavlinkClient(SilentPipe(), demo.bench.frame)
    pilot = Pilot(client, demo.mission, demo.cameras.render_depth)
    for tick in range(600):
        pilot.update(tick * 20_000)
    assert pilot.phase is Phase.FAILED
    assert pilot.verdict.reason == "phase connect took more than 10 s"


def test_the_touchdown_point_comes_from_the_camera_and_not_from_the_annotation(demo):
    # The annotation lies half a metre above the container, and a crate stands on its centroid.
    higher = tuple((x, y, z + 0.5) for x, y, z in ON_CONTAINER.polygon)
    x, y, z = ON_CONTAINER.centroid
    wrong = dataclasses.replace(ON_CONTAINER, polygon=higher, centroid=(x, y, z + 0.5))
    crate = thing(90, "crate", (x, y, z + 0.2), (0.5, 0.5, 0.4), CONTAINER)
    scene = dataclasses.replace(yard(), objects=(*yard().objects, crate))
    demo = demo(scene, wrong, known=yard())
    pilot = demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert pilot.touchdown_enu_m[2] == pytest.approx(z, abs=0.3)
    assert 0.6 < math.dist(pilot.touchdown_enu_m[:2], (x, y)) < 2.5
    assert demo.bench.plant.truth.position_enu_m[2] == pytest.approx(z + 0.11, abs=0.02)
