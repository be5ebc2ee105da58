"""Every command is acknowledged with what came of it, and does what it says."""

import math

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.hardware_uid import hardware_uid
from flightsim.mavlink.personalities import PX4
from tests.flightsim.mavlink.wire import named

ACCEPTED = mav.MAV_RESULT_ACCEPTED
REJECTED = mav.MAV_RESULT_TEMPORARILY_REJECTED
DENIED = mav.MAV_RESULT_DENIED
UNSUPPORTED = mav.MAV_RESULT_UNSUPPORTED
NAN = math.nan
_ALL_NAN = (NAN,) * 7
_RELATIVE = mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT


def _lat_lon(flight, north_m, east_m):
    x, y, _ = flight.plant.truth.position_enu_m
    place = flight.frame.geodetic_from_enu((x + east_m, y + north_m, 0.0))
    return round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)


def test_arming_needs_a_position_and_says_why(flight):
    flight.autopilot.parameters.set("COM_ARM_WO_GPS", 0)
    flight.command(mav.MAV_CMD_DO_SET_MODE, 1, 4, 3)
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == REJECTED
    texts = [message.text for message in named(flight.heard, "STATUSTEXT")]
    assert [text for text in texts if "rming denied" in text]
    assert len(texts) == len(set(texts))
    flight.become_ready()
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 0) == ACCEPTED
    assert not flight.autopilot.is_armed


def test_why_a_mode_is_refused_is_said_once(flight):
    flight.become_ready()
    flight.heard.clear()
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, 1, 6, 0) == REJECTED
    flight.run(0.1)
    whole = "".join(message.text for message in named(flight.heard, "STATUSTEXT"))
    assert whole == "Switching to Offboard denied: no offboard setpoints arrive"


def test_disarming_in_the_air_needs_force(flight):
    flight.take_off()
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 0) == REJECTED
    assert flight.autopilot.is_armed
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196) == ACCEPTED
    assert not flight.autopilot.is_armed


@pytest.mark.parametrize(
    ("main", "sub", "mode"),
    [(4, 3, Mode.HOLD), (4, 5, Mode.RETURN), (4, 6, Mode.LAND), (2, 0, Mode.ALTITUDE)],
)
def test_modes_are_set_by_px4_numbers(flight, main, sub, mode):
    flight.take_off(5.0)
    if mode is Mode.ALTITUDE:
        flight.send("MANUAL_CONTROL", 1, 0, 0, 500, 0, 0)
        flight.step()
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, 1, main, sub) == ACCEPTED
    assert flight.autopilot.mode is mode
    flight.run(1.0)
    heartbeat = flight.last("HEARTBEAT")
    assert heartbeat.custom_mode == main << 16 | sub << 24


def test_modes_are_set_by_their_standard_numbers_and_by_the_old_message(flight):
    flight.take_off(5.0)
    assert (
        flight.command(mav.MAV_CMD_DO_SET_STANDARD_MODE, mav.MAV_STANDARD_MODE_SAFE_RECOVERY)
        == ACCEPTED
    )
    assert flight.autopilot.mode is Mode.RETURN
    cruise = mav.MAV_STANDARD_MODE_CRUISE
    assert flight.command(mav.MAV_CMD_DO_SET_STANDARD_MODE, cruise) == DENIED
    assert flight.autopilot.mode is Mode.RETURN
    flight.send("SET_MODE", 1, 1, 4 << 16 | 3 << 24)
    flight.step()
    assert flight.autopilot.mode is Mode.HOLD


@pytest.mark.parametrize("params", [(0, 4, 3), (1, 99, 0), (1, 4, 77), (1, -1, 0), (1, 1e9, 0)])
def test_modes_that_do_not_exist_are_denied(flight, params):
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, *params) == DENIED


def test_a_takeoff_climbs_to_the_altitude_above_the_sea(flight):
    flight.become_ready()
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    altitude_m = flight.autopilot.home.geodetic.altitude_m + 7.0
    assert flight.command(mav.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, NAN, NAN, altitude_m) == ACCEPTED
    flight.run(10.0)
    up_m = flight.plant.truth.position_enu_m[2] - flight.autopilot.home.position_enu_m[2]
    assert up_m == pytest.approx(7.0, abs=0.5)


def test_a_reposition_flies_to_a_place_above_home_and_turns_there(flight):
    flight.take_off()
    latitude, longitude = _lat_lon(flight, 15.0, -10.0)
    x, y, _ = flight.plant.truth.position_enu_m
    assert (
        flight.command_int(
            mav.MAV_CMD_DO_REPOSITION, _RELATIVE, -1, 1, 0, 1.5, latitude, longitude, 14.0
        )
        == ACCEPTED
    )
    flight.run(12.0)
    truth = flight.plant.truth.position_enu_m
    up_m = truth[2] - flight.autopilot.home.position_enu_m[2]
    assert (truth[0] - x, truth[1] - y, up_m) == pytest.approx((-10.0, 15.0, 14.0), abs=0.7)
    assert flight.last("ATTITUDE").yaw == pytest.approx(1.5, abs=0.1)


def test_a_reposition_keeps_what_it_does_not_name(flight):
    flight.take_off()
    before = flight.plant.truth.position_enu_m
    not_given = 0x7FFFFFFF
    assert (
        flight.command_int(mav.MAV_CMD_DO_REPOSITION, 5, -1, 1, 0, NAN, not_given, not_given, NAN)
        == ACCEPTED
    )
    flight.run(3.0)
    assert flight.plant.truth.position_enu_m == pytest.approx(before, abs=0.6)


def test_speed_pause_and_altitude_are_changed_on_the_way(flight):
    flight.take_off()
    assert flight.command(mav.MAV_CMD_DO_CHANGE_SPEED, 1, 3.0) == ACCEPTED
    assert flight.command(mav.MAV_CMD_DO_CHANGE_SPEED, 1, -2) == ACCEPTED
    assert flight.command(mav.MAV_CMD_DO_CHANGE_SPEED, 3, 2.0) == DENIED
    assert flight.command(mav.MAV_CMD_DO_CHANGE_SPEED, 1, 1e9) == DENIED
    assert flight.command(mav.MAV_CMD_DO_CHANGE_ALTITUDE, 15.0, 3) == ACCEPTED
    flight.run(6.0)
    up_m = flight.plant.truth.position_enu_m[2] - flight.autopilot.home.position_enu_m[2]
    assert up_m == pytest.approx(15.0, abs=0.6)
    assert flight.command(mav.MAV_CMD_DO_PAUSE_CONTINUE, 0) == ACCEPTED
    assert flight.command(mav.MAV_CMD_DO_PAUSE_CONTINUE, 5) == DENIED
    assert flight.command(mav.MAV_CMD_CONDITION_YAW, 90, 20, 1, 0) == ACCEPTED
    flight.run(8.0)
    assert flight.last("ATTITUDE").yaw == pytest.approx(math.pi / 2, abs=0.1)


def test_an_orbit_is_flown_around_its_centre(flight):
    flight.take_off()
    latitude, longitude = _lat_lon(flight, 8.0, 0.0)
    x, y, _ = flight.plant.truth.position_enu_m
    assert (
        flight.command_int(
            mav.MAV_CMD_DO_ORBIT, _RELATIVE, 8.0, 3.0, 0, NAN, latitude, longitude, NAN
        )
        == ACCEPTED
    )
    flight.run(10.0)
    truth = flight.plant.truth.position_enu_m
    assert math.hypot(truth[0] - x, truth[1] - (y + 8.0)) == pytest.approx(8.0, abs=1.0)


@pytest.mark.parametrize("frame", [0, 3, 6])
def test_the_height_of_an_orbit_is_above_the_sea_in_every_frame(flight, frame):
    flight.take_off(8.0)
    latitude, longitude = _lat_lon(flight, 8.0, 0.0)
    home = flight.autopilot.home
    place = (latitude, longitude, home.geodetic.altitude_m + 12.0)
    assert flight.command_int(mav.MAV_CMD_DO_ORBIT, frame, 8.0, 3.0, 0, NAN, *place) == ACCEPTED
    flight.run(20.0)
    up_m = flight.plant.truth.position_enu_m[2]
    assert up_m - home.position_enu_m[2] == pytest.approx(12.0, abs=0.7)


def test_home_is_moved_and_asked_for(flight):
    flight.become_ready()
    assert flight.command(mav.MAV_CMD_DO_SET_HOME, 1) == ACCEPTED
    latitude, longitude = _lat_lon(flight, 5.0, 5.0)
    assert (
        flight.command_int(mav.MAV_CMD_DO_SET_HOME, 5, 0, 0, 0, 0, latitude, longitude, 488.0)
        == ACCEPTED
    )
    flight.heard.clear()
    assert flight.command(mav.MAV_CMD_GET_HOME_POSITION) == ACCEPTED
    home = flight.last("HOME_POSITION")
    assert (home.latitude, home.longitude) == pytest.approx((latitude, longitude), abs=1)
    assert flight.command_int(mav.MAV_CMD_DO_SET_HOME, 5, 0, 0, 0, 0, 0, 0, 488.0) == DENIED


def test_home_is_not_there_at_once(flight):
    assert (
        flight.command(mav.MAV_CMD_REQUEST_MESSAGE, LAYOUTS["HOME_POSITION"].message_id) == REJECTED
    )
    assert flight.command(mav.MAV_CMD_GET_HOME_POSITION) == REJECTED


@pytest.mark.parametrize(
    ("number", "params"),
    [
        (mav.MAV_CMD_NAV_TAKEOFF, (0, 0, 0, 0, 1000.0, 8.5, 500.0)),
        (mav.MAV_CMD_NAV_TAKEOFF, (0, 0, 0, 0, 47.0, 8.5, 1e30)),
        (mav.MAV_CMD_DO_REPOSITION, (-1, 1, 0, NAN, 95.0, 8.5, 500.0)),
        (mav.MAV_CMD_DO_REPOSITION, (-1, 1, 0, NAN, 47.0, math.inf, 500.0)),
        (mav.MAV_CMD_NAV_LAND, (0, 0, 0, NAN, -91.0, 0.5, 0.0)),
        (mav.MAV_CMD_COMPONENT_ARM_DISARM, (2,)),
        (mav.MAV_CMD_COMPONENT_ARM_DISARM, (0.5,)),
        (mav.MAV_CMD_COMPONENT_ARM_DISARM, (NAN,)),
        (mav.MAV_CMD_DO_SET_MODE, (math.inf, 4, 3)),
        (mav.MAV_CMD_MISSION_START, (7, 9)),
        (mav.MAV_CMD_MISSION_START, (-1, 0)),
        (mav.MAV_CMD_DO_SET_MISSION_CURRENT, (-3,)),
        (mav.MAV_CMD_DO_SET_MISSION_CURRENT, (1e30,)),
        (mav.MAV_CMD_SET_MESSAGE_INTERVAL, (NAN, 1e5)),
        (mav.MAV_CMD_SET_MESSAGE_INTERVAL, (30, NAN)),
        (mav.MAV_CMD_SET_MESSAGE_INTERVAL, (30.5, 1e5)),
        (mav.MAV_CMD_REQUEST_MESSAGE, (-5,)),
        (mav.MAV_CMD_REQUEST_MESSAGE, (1e9,)),
        (mav.MAV_CMD_REQUEST_MESSAGE, (NAN, NAN)),
        (mav.MAV_CMD_GET_MESSAGE_INTERVAL, (65_000,)),
        (mav.MAV_CMD_DO_CHANGE_ALTITUDE, (NAN, 0)),
        (mav.MAV_CMD_DO_CHANGE_ALTITUDE, (10.0, 1)),
        (mav.MAV_CMD_DO_CHANGE_SPEED, (NAN, 1e12)),
        (mav.MAV_CMD_DO_ORBIT, (0.0, 3.0, 0, NAN, 47.4, 8.5, NAN)),
        (mav.MAV_CMD_DO_FLIGHTTERMINATION, (0,)),
    ],
)
def test_values_out_of_range_are_denied_and_the_flight_goes_on(flight, number, params):
    flight.take_off(5.0)
    mode = flight.autopilot.mode
    assert flight.command(number, *params) == DENIED
    assert flight.autopilot.mode is mode
    assert flight.autopilot.is_armed


@pytest.mark.parametrize("frame", [1, 2, 8, 99, 255])
def test_frames_without_a_globe_are_denied(flight, frame):
    flight.take_off(5.0)
    assert (
        flight.command_int(mav.MAV_CMD_DO_REPOSITION, frame, -1, 1, 0, NAN, 10, 10, 5.0) == DENIED
    )


def test_altitude_mode_has_the_standard_number_of_altitude_hold():
    entry = PX4.standard(mav.MAV_STANDARD_MODE_ALTITUDE_HOLD)
    assert entry is not None
    assert entry.mode is Mode.ALTITUDE


@pytest.mark.parametrize("number", [0, 16, 183, 4242, 65535])
def test_unknown_commands_are_answered_as_unsupported(flight, number):
    assert flight.command(number, *_ALL_NAN) == UNSUPPORTED


def test_commands_for_somebody_else_are_not_answered(flight):
    for system, component in ((2, 1), (1, 100), (1, 154)):
        flight.send(
            "COMMAND_LONG", system, component, mav.MAV_CMD_COMPONENT_ARM_DISARM, 0, *(0.0,) * 7
        )
    assert not named(flight.run(0.5), "COMMAND_ACK")
    flight.send("COMMAND_LONG", 0, 0, mav.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 0, *(0.0,) * 7)
    assert len(named(flight.step(), "COMMAND_ACK")) == 1


def test_intervals_are_set_and_told(flight):
    attitude = LAYOUTS["ATTITUDE"].message_id
    flight.become_ready()
    assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, attitude, 500_000) == ACCEPTED
    assert len(named(flight.run(4.0), "ATTITUDE")) == 8
    assert flight.command(mav.MAV_CMD_GET_MESSAGE_INTERVAL, attitude) == ACCEPTED
    assert flight.last("MESSAGE_INTERVAL").interval_us == 500_000
    assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, attitude, -1) == ACCEPTED
    flight.run(0.1)
    assert not named(flight.run(2.0), "ATTITUDE")
    assert (
        flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, LAYOUTS["STATUSTEXT"].message_id, 1e6)
        == DENIED
    )
    flight.send("REQUEST_DATA_STREAM", 1, 1, 10, 4, 1)
    assert len(named(flight.run(2.0), "ATTITUDE")) == 8


def test_who_the_vehicle_is(flight):
    for number, params in (
        (mav.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, (1,)),
        (mav.MAV_CMD_REQUEST_MESSAGE, (148,)),
        (mav.MAV_CMD_REQUEST_PROTOCOL_VERSION, (1,)),
        (mav.MAV_CMD_REQUEST_MESSAGE, (300,)),
    ):
        assert flight.command(number, *params) == ACCEPTED
    version = flight.last("AUTOPILOT_VERSION")
    assert version.flight_sw_version >> 24 == 1
    assert version.capabilities & (8 | 16 | 128 | 8192) == 8 | 16 | 128 | 8192
    assert version.uid != 0
    assert bytes(version.uid2) == hardware_uid(1)


def test_each_vehicle_has_a_hardware_uid_of_its_own():
    uids = {hardware_uid(system_id) for system_id in range(1, 256)}
    assert len(uids) == 255
    assert {len(uid) for uid in uids} == {18}


def test_the_list_of_modes_is_complete_and_every_selectable_one_is_named(flight):
    assert flight.command(mav.MAV_CMD_REQUEST_MESSAGE, 435, 0) == ACCEPTED
    modes = named(flight.heard, "AVAILABLE_MODES")
    assert [mode.mode_index for mode in modes] == list(range(1, modes[0].number_modes + 1))
    assert len({mode.custom_mode for mode in modes}) == len(modes)
    flight.heard.clear()
    assert flight.command(mav.MAV_CMD_REQUEST_MESSAGE, 435, 3) == ACCEPTED
    assert [mode.mode_index for mode in named(flight.heard, "AVAILABLE_MODES")] == [3]
    assert flight.command(mav.MAV_CMD_REQUEST_MESSAGE, 435, 999) == DENIED


def test_a_mission_is_started_and_its_items_are_announced(flight):
    flight.become_ready()
    latitude, longitude = _lat_lon(flight, 0.0, 0.0)
    flight.send("MISSION_COUNT", 1, 1, 2, 0)
    flight.step()
    for index, (number, altitude) in enumerate(
        ((mav.MAV_CMD_NAV_TAKEOFF, 5.0), (mav.MAV_CMD_NAV_WAYPOINT, 8.0))
    ):
        fields = (_RELATIVE, number, 0, 1, 0, 0, 0, NAN, latitude, longitude, altitude, 0)
        flight.send("MISSION_ITEM_INT", 1, 1, index, *fields)
        flight.step()
    assert flight.last("MISSION_ACK").type == ACCEPTED
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert flight.command(mav.MAV_CMD_MISSION_START, 0, 0) == ACCEPTED
    flight.run_until(lambda: flight.autopilot.mission.is_finished)
    flight.run(1.5)
    assert [m.seq for m in named(flight.heard, "MISSION_ITEM_REACHED")] == [0, 1]
    current = flight.last("MISSION_CURRENT")
    assert (current.total, current.mission_state) == (2, 5)
    flight.send("MISSION_SET_CURRENT", 1, 1, 0)
    assert named(flight.step(), "MISSION_CURRENT")[-1].seq == 0
    assert flight.command(mav.MAV_CMD_DO_SET_MISSION_CURRENT, 1) == ACCEPTED
    flight.send("MISSION_SET_CURRENT", 1, 1, 77)
    flight.step()
    assert flight.autopilot.mission.current_index == 1


def test_parameters_are_reset_only_on_the_ground(flight):
    flight.autopilot.parameters.set("MIS_TAKEOFF_ALT", 9.0)
    assert flight.command(mav.MAV_CMD_PREFLIGHT_STORAGE, 1) == UNSUPPORTED
    assert flight.command(mav.MAV_CMD_PREFLIGHT_STORAGE, 2) == ACCEPTED
    assert flight.autopilot.parameters["MIS_TAKEOFF_ALT"] == 2.5
    flight.take_off(5.0)
    assert flight.command(mav.MAV_CMD_PREFLIGHT_STORAGE, 2) == REJECTED


def test_termination_is_for_good(flight):
    flight.take_off(3.0)
    assert flight.command(mav.MAV_CMD_DO_FLIGHTTERMINATION, 1) == ACCEPTED
    flight.run(1.1)
    assert flight.last("HEARTBEAT").system_status == 8
