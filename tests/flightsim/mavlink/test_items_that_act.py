"""Every mission item that is accepted changes something; the others are refused by name."""

import pytest

from flightsim.autopilot.mission_check import check_mission
from flightsim.autopilot.mission_item import (
    PAYLOAD_COMMANDS,
    UNAVAILABLE_COMMANDS,
    Cmd,
    MissionItem,
)
from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from flightsim.payload import PayloadCfg
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.test_personalities import copter, fly, upload, waypoint
from tests.flightsim.mavlink.wire import named

__all__ = ["copter"]
_UNSUPPORTED = mav.MAV_MISSION_UNSUPPORTED


def _texts(flight):
    return "".join(m.text for m in named(flight.heard, "STATUSTEXT"))


@pytest.mark.parametrize("command", [c for c in UNAVAILABLE_COMMANDS if c < 5000])
def test_an_item_that_would_change_nothing_is_refused_by_name(copter, command):
    known = mav.enums["MAV_CMD"].get(command)  # two are of ArduPilot's own dialect
    name = "DO_SET_RESUME_REPEAT_DIST" if command == 215 else "DO_SPRAYER"
    name = known.name.removeprefix("MAV_CMD_") if known else name
    assert upload(copter, [waypoint(16), waypoint(22), waypoint(command)]) == _UNSUPPORTED
    copter.step(3)
    assert f"command {command}, {name}: " in _texts(copter)


def test_px4_refuses_the_item_for_the_fence_that_it_does_not_know(flight):
    flight.send("MISSION_COUNT", 1, 1, 1)
    flight.step(2)
    flight.send("MISSION_ITEM_INT", *(1, 1, 0), *waypoint(Cmd.FENCE_ENABLE))
    (ack,) = named(flight.step(3), "MISSION_ACK")
    assert ack.type == _UNSUPPORTED


def test_every_payload_item_has_somebody_who_obeys(field):
    flight = Flight(field, payload=PayloadCfg())
    try:
        assert set(flight.server._payload._orders) >= PAYLOAD_COMMANDS
    finally:
        flight.close()


def test_every_item_that_is_accepted_is_known_by_name():
    accepted = []
    for command in range(6000):
        item = MissionItem(frame=3, command=command, param1=0.0, param2=1.0, x=47.4, y=8.5)
        try:
            check_mission((item,))
        except ValueError:
            continue
        accepted.append(command)
    assert set(accepted) == ({*Cmd} - set(range(5000, 6000))) | PAYLOAD_COMMANDS


def test_a_mission_turns_the_fence_off_and_on(copter):
    fly(copter, 5.0)
    items = [waypoint(16), waypoint(207, p1=0.0), waypoint(93, p1=2.0), waypoint(207, p1=1.0)]
    assert upload(copter, items) == mav.MAV_MISSION_ACCEPTED
    assert copter.command(mav.MAV_CMD_MISSION_START) == mav.MAV_RESULT_ACCEPTED
    copter.step(5)
    assert copter.autopilot.fence.switch is False
    copter.run(3.0)
    assert copter.autopilot.fence.switch is True
    assert "Fence disabled by mission" in _texts(copter)


def test_a_fence_that_a_mission_turns_off_does_not_refuse_what_comes_after(copter):
    fly(copter, 5.0)
    circle = MissionItem(frame=3, command=5003, param1=20.0, x=47.39994, y=8.50016)
    copter.autopilot.fence.replace([circle])
    far = waypoint(16, lat=47.401, lon=8.50016)
    assert upload(copter, [waypoint(16), far]) == mav.MAV_MISSION_ACCEPTED
    assert copter.command(mav.MAV_CMD_MISSION_START) != mav.MAV_RESULT_ACCEPTED
    assert upload(copter, [waypoint(16), waypoint(207), far]) == mav.MAV_MISSION_ACCEPTED
    assert copter.command(mav.MAV_CMD_MISSION_START) == mav.MAV_RESULT_ACCEPTED


def test_a_landing_is_begun_where_the_mission_marks_it(copter):
    fly(copter, 5.0)
    assert copter.command(mav.MAV_CMD_DO_LAND_START) != mav.MAV_RESULT_ACCEPTED
    assert "the mission has no DO_LAND_START" in _texts(copter)
    items = [waypoint(16), waypoint(93, p1=60.0), waypoint(189), waypoint(93, p1=30.0)]
    assert upload(copter, items) == mav.MAV_MISSION_ACCEPTED
    assert copter.command(mav.MAV_CMD_DO_LAND_START) == mav.MAV_RESULT_ACCEPTED
    copter.step(3)
    assert copter.autopilot.mode is Mode.MISSION
    assert copter.autopilot.mission.current_index == 2
