"""QGroundControl and mavros, which cannot run here: their exchanges, played message by message."""

import math

import pytest

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import Wire, named

_AUTOPILOT_VERSION = LAYOUTS["AUTOPILOT_VERSION"].message_id
_AVAILABLE_MODES = LAYOUTS["AVAILABLE_MODES"].message_id
_COMPONENT_METADATA = LAYOUTS["COMPONENT_METADATA"].message_id
_PX4_OFFBOARD = 6 << 16
_POSITION_ALONE = 0b1101_1111_1000
"""Type mask that ignores all but the position."""
_RETURN = mav.MAV_CMD_NAV_RETURN_TO_LAUNCH


def _request(flight: Flight, message_id: int, *parameters: float) -> int:
    """Ask for a message by MAV_CMD_REQUEST_MESSAGE; returns the result."""
    return flight.command(mav.MAV_CMD_REQUEST_MESSAGE, message_id, *parameters)


def _download_plan(flight: Flight, mission_type: int) -> list[int]:
    """Download a mission, a fence or rally points as QGroundControl does; returns the commands."""
    flight.send("MISSION_REQUEST_LIST", 1, 1, mission_type)
    (count,) = named(flight.step(), "MISSION_COUNT")
    assert count.mission_type == mission_type
    items = []
    for number in range(count.count):
        flight.send("MISSION_REQUEST_INT", 1, 1, number, mission_type)
        items += named(flight.step(), "MISSION_ITEM_INT")
    flight.send("MISSION_ACK", 1, 1, 0, mission_type)
    assert not named(flight.run(2.0), "MISSION_ITEM_INT")
    return [item.command for item in items]


def test_qgroundcontrol_gets_an_answer_to_all_that_it_asks_for_when_it_connects(flight):
    assert _request(flight, _AUTOPILOT_VERSION) == mav.MAV_RESULT_ACCEPTED
    version = flight.last("AUTOPILOT_VERSION")
    assert version.capabilities & mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    assert _request(flight, _AVAILABLE_MODES, 1) == mav.MAV_RESULT_ACCEPTED
    n_modes = flight.last("AVAILABLE_MODES").number_modes
    for index in range(2, n_modes + 1):
        assert _request(flight, _AVAILABLE_MODES, index) == mav.MAV_RESULT_ACCEPTED
        assert flight.last("AVAILABLE_MODES").mode_index == index
    assert _request(flight, _COMPONENT_METADATA) == mav.MAV_RESULT_ACCEPTED
    assert flight.last("COMPONENT_METADATA").uri.startswith("mftp://")
    flight.send("PARAM_REQUEST_LIST", 1, 0)
    check, *values = named(flight.run(5.0), "PARAM_VALUE")
    assert check.param_id == "_HASH_CHECK"  # by which it knows whether it has them in its cache
    assert len(values) == check.param_count > 50
    assert [value.param_index for value in values] == list(range(len(values)))
    for mission_type in (0, 1, 2):
        assert _download_plan(flight, mission_type) == []
    assert named(flight.run(1.1), "HEARTBEAT")


def test_qgroundcontrol_reads_back_the_plan_that_it_wrote(flight):
    flight.become_ready()
    home = flight.frame.geodetic_from_enu(flight.plant.truth.position_enu_m)
    x, y = round(home.latitude_deg * 1e7), round(home.longitude_deg * 1e7)
    frame = mav.MAV_FRAME_GLOBAL_RELATIVE_ALT
    commands = [mav.MAV_CMD_NAV_TAKEOFF, mav.MAV_CMD_NAV_WAYPOINT, _RETURN]
    flight.send("MISSION_COUNT", 1, 1, len(commands), 0)
    for number, command in enumerate(commands):
        (request,) = named(flight.step(), "MISSION_REQUEST_INT")
        assert request.seq == number
        place = (0, 0, 0) if command == _RETURN else (x + 1000 * number, y, 10.0)
        values = (number, frame, command, int(number == 0), 1, 0, 0, 0, math.nan, *place, 0)
        flight.send("MISSION_ITEM_INT", 1, 1, *values)
    (ack,) = named(flight.step(), "MISSION_ACK")
    assert ack.type == mav.MAV_MISSION_ACCEPTED
    assert _download_plan(flight, 0) == commands


class Mavros:
    """What mavros sends: the plugins sys_status, time, param, setpoint_raw and command."""

    def __init__(self, flight: Flight):
        self.flight = flight
        flight.wire = Wire(system_id=255, component_id=190)
        flight.send("HEARTBEAT", mav.MAV_TYPE_ONBOARD_CONTROLLER, 8, 0, 0, 4, 3)

    def stream_setpoint(self, height_m: float, seconds: float) -> None:
        """Stream a position at 50 Hz, as a node that publishes to setpoint_position does."""
        for _ in range(round(50 * seconds)):
            self.flight.send(
                "SET_POSITION_TARGET_LOCAL_NED",
                *(0, 1, 1, mav.MAV_FRAME_LOCAL_NED, _POSITION_ALONE, 0.0, 0.0, -height_m),
                *(0.0,) * 8,
            )
            self.flight.step()


def test_mavros_connects_and_flies_offboard(flight):
    mavros = Mavros(flight)
    flight.become_ready()
    # Its clock first, then what it asks for once a vehicle is there.
    flight.send("TIMESYNC", 0, 1_000)
    (answer,) = named(flight.step(), "TIMESYNC")
    assert answer.ts1 == 1_000
    flight.send("SYSTEM_TIME", 1_700_000_000_000_000, 0)
    assert flight.command(mav.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1) == 0
    assert named(flight.heard, "AUTOPILOT_VERSION")
    assert flight.command(mav.MAV_CMD_GET_HOME_POSITION) == 0
    assert named(flight.heard, "HOME_POSITION")
    flight.send("PARAM_REQUEST_READ", 1, 1, b"MAV_SYS_ID", -1)
    assert named(flight.step(), "PARAM_VALUE")[0].param_id == "MAV_SYS_ID"
    attitude = LAYOUTS["ATTITUDE_QUATERNION"].message_id
    assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, attitude, 20_000) == 0

    mavros.stream_setpoint(3.0, 0.6)
    flight.send("SET_MODE", 1, mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, _PX4_OFFBOARD)
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    mavros.stream_setpoint(3.0, 8.0)
    assert flight.last("HEARTBEAT").custom_mode == _PX4_OFFBOARD
    assert flight.last("LOCAL_POSITION_NED").z == pytest.approx(-3.0, abs=0.3)
    assert len(named(flight.step(50), "ATTITUDE_QUATERNION")) == 50
