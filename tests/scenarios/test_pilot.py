"""The pilot in the whole stack: it lands, it gives up what is unsafe, it says why it failed."""

import dataclasses
import math

import pytest

from flightsim.autopilot.modes import Mode
from scenarios.cameras import Cameras
from scenarios.mavlink_client import MavlinkClient
from scenarios.mission import plan_mission
from scenarios.pilot import Phase, Pilot
from scenarios.scoring import FlightLog
from scenarios.testbench import Testbench, TestbenchCfg
from tests.scenarios.landing_scenes import CONTAINER, ON_CONTAINER, ON_LAWN, thing, yard


class Demo:
    """Testbench, cameras and pilot, ready to fly."""

    def __init__(self, scene, area=ON_CONTAINER, *, vehicle="iris", alternates=(), known=None):
        """The pilot's map is `known`, if that is not the scene itself."""
        observers = []
        self.bench = Testbench(
            TestbenchCfg(speed="max", vehicle=vehicle),
            scene=scene,
            has_network=False,
            observers=observers,
        )
        self.cameras = Cameras(self.bench.world, self.bench.plant)
        mission = plan_mission(known or scene, self.bench.airframe, area=area)
        mission = dataclasses.replace(mission, alternates=tuple(alternates))
        client = MavlinkClient(self.bench.pilot_link.client, self.bench.frame)
        self.pilot = Pilot(client, mission, self.cameras.render)
        self.log = FlightLog(self.bench.plant)
        observers += [self.log.on_tick, lambda: self.pilot.update(self.bench.plant.time_us)]

    def fly(self, until=lambda: False, limit_s=120.0):
        self.bench.simulator.run(
            until_us=round(limit_s * 1e6), stop=lambda: self.pilot.is_done or until()
        )
        return self.pilot

    def targets(self):
        return [change.target for change in self.pilot.transitions]

    def score(self):
        leg_m = self.bench.airframe.leg_length_m
        return self.log.score(self.pilot.area, self.pilot.touchdown_enu_m, leg_m)


@pytest.fixture
def demo():
    made = []

    def make(*args, **options):
        made.append(Demo(*args, **options))
        return made[-1]

    yield make
    for each in made:
        each.cameras.close()
        each.bench.close()


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
        Phase.ALIGN,
        Phase.DESCEND,
        Phase.TOUCHDOWN,
        Phase.DISARM,
        Phase.DONE,
    ]
    assert all(change.reason for change in pilot.transitions)
    assert not demo.bench.autopilot.is_armed
    score = demo.score()
    assert score.contacts_before_touchdown == 0
    assert score.is_inside_area
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
    assert demo.score().is_inside_area


def test_with_no_area_left_it_sends_the_vehicle_home_and_says_why(demo):
    demo = demo(yard(has_crates_on_top=True), known=yard())
    pilot = demo.fly()
    assert not pilot.verdict.success
    assert pilot.verdict.reason == "no safe place seen on area 0"
    assert demo.targets()[-2:] == [Phase.RETURN, Phase.FAILED]
    assert demo.bench.autopilot.mode is Mode.RETURN


def test_it_starts_again_from_the_top_when_the_place_turns_bad_on_the_way_down(demo):
    demo = demo(yard())
    pilot = demo.fly(until=lambda: demo.pilot.phase is Phase.DESCEND)
    # From now on the camera sees a step of half a metre in what was level before.
    render = demo.cameras.render

    def with_a_step(camera):
        frame = render(camera)
        depth = frame.depth_m.copy()
        depth[:, 150:] -= 0.5
        return dataclasses.replace(frame, depth_m=depth)

    pilot._watch._frames = with_a_step
    demo.fly(until=lambda: demo.pilot.phase is Phase.CLIMB)
    assert pilot.phase is Phase.CLIMB
    assert "no longer looks safe" in pilot.transitions[-1].reason
    demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert demo.targets().count(Phase.SEARCH) == 2


def test_a_vehicle_that_is_switched_off_in_the_air_ends_the_flight(demo):
    demo = demo(yard())
    pilot = demo.fly(until=lambda: demo.pilot.phase is Phase.NAVIGATE)
    demo.bench.autopilot.disarm(is_forced=True)
    demo.fly()
    assert pilot.phase is Phase.FAILED
    assert pilot.verdict.reason.startswith("disarmed in phase navigate")


def test_somebody_who_takes_over_is_let_to(demo):
    demo = demo(yard())
    pilot = demo.fly(until=lambda: demo.pilot.phase is Phase.NAVIGATE)
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
    pilot = Pilot(
        MavlinkClient(SilentPipe(), demo.bench.frame), demo.pilot._mission, demo.cameras.render
    )
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
