"""Both flight stacks over one autopilot: what differs between them, and that it does."""

import math
import struct

import pytest
from pymavlink import mavutil

from flightsim.autopilot.mission_item import MissionItem
from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ARDUPILOT, PERSONALITIES
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

GUIDED, STABILIZE, AUTO, LOITER, RTL, LAND, POSHOLD, BRAKE = 4, 0, 3, 5, 6, 9, 16, 17
NAN = math.nan


@pytest.fixture
def copter(field):
    """A fresh vehicle that behaves as ArduPilot's."""
    flight = Flight(field, personality=ARDUPILOT)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    yield flight
    flight.server.close()


def set_mode(copter, number):
    return copter.command(mav.MAV_CMD_DO_SET_MODE, 1, number)


def heartbeat(copter):
    copter.run(1.1)
    return copter.last("HEARTBEAT")


def fly(copter, height_m=10.0):
    copter.become_ready()
    assert set_mode(copter, GUIDED) == 0
    assert copter.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    assert copter.command(mav.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, height_m) == 0
    up_m = copter.plant.truth.position_enu_m[2]
    copter.run_until(lambda: copter.plant.truth.position_enu_m[2] > up_m + height_m - 0.3)
    copter.skip(4.0)


def up_m(copter):
    return copter.plant.truth.position_enu_m[2] - copter.autopilot.home.position_enu_m[2]


@pytest.mark.parametrize("name", PERSONALITIES)
def test_every_mode_of_ours_is_reported_as_one_that_clients_know(name):
    personality = PERSONALITIES[name]
    for mode in Mode:
        heartbeat = mav.MAVLink_heartbeat_message(
            2,
            personality.autopilot,
            personality.entry(mode).base_mode,
            personality.entry(mode).custom_mode,
            3,
            3,
        )
        word = mavutil.mode_string_v10(heartbeat)
        assert "Mode(" not in word, (mode, word)
        assert word != "UNKNOWN", mode


def test_the_heartbeat_and_the_version_are_ardupilots(copter):
    beat = heartbeat(copter)
    assert beat.autopilot == mav.MAV_AUTOPILOT_ARDUPILOTMEGA
    assert mavutil.mode_string_v10(beat) == "GUIDED"
    assert copter.command(mav.MAV_CMD_REQUEST_MESSAGE, 148) == 0
    version = copter.last("AUTOPILOT_VERSION")
    assert version.flight_sw_version >> 24 == 4
    assert not version.capabilities & mav.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE


@pytest.mark.parametrize("number", [GUIDED, LOITER, POSHOLD, BRAKE, STABILIZE, AUTO])
def test_the_mode_that_was_chosen_is_reported_though_ours_serves_several(copter, number):
    copter.become_ready()
    if number == AUTO:
        upload(copter, [waypoint(0), waypoint(22), waypoint(16)])
    assert set_mode(copter, LOITER) == 0
    assert set_mode(copter, number) == 0
    assert heartbeat(copter).custom_mode == number


def test_a_takeoff_climbs_to_its_height_above_home_and_stays_guided(copter):
    copter.become_ready()
    takeoff = (mav.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0)
    assert copter.command(*takeoff, 7) == mav.MAV_RESULT_FAILED  # not armed
    fly(copter, 7.0)
    assert up_m(copter) == pytest.approx(7.0, abs=0.3)
    assert heartbeat(copter).custom_mode == GUIDED


def test_a_single_item_is_flown_to_while_guided_and_refused_otherwise(copter):
    fly(copter)
    home = copter.autopilot.home.geodetic
    goto = waypoint(16, lat=home.latitude_deg + 1e-4, lon=home.longitude_deg, z=12.0)
    copter.send("MISSION_ITEM_INT", *(1, 1, 0), *goto[:2], 2, *goto[3:])
    assert named(copter.step(2), "MISSION_ACK")[-1].type == mav.MAV_MISSION_ACCEPTED
    copter.skip(15.0)
    assert up_m(copter) == pytest.approx(12.0, abs=0.3)
    north_m = copter.plant.truth.position_enu_m[1] - copter.autopilot.home.position_enu_m[1]
    assert north_m == pytest.approx(11.1, abs=0.5)
    assert set_mode(copter, LOITER) == 0
    copter.send("MISSION_ITEM_INT", *(1, 1, 0), *goto[:2], 2, *goto[3:])
    assert named(copter.step(2), "MISSION_ACK")[-1].type == mav.MAV_MISSION_DENIED
    texts = [message.text for message in named(copter.heard, "STATUSTEXT")]
    assert "Item refused: not flying in guided mode" in texts


def test_headings_of_takeoffs_and_places_are_ignored_as_by_copters(copter):
    copter.become_ready()
    assert copter.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    assert copter.command(mav.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 5.0) == 0
    copter.skip(10.0)
    assert math.degrees(copter.server._view.rpy_rad[2]) == pytest.approx(90.0 - 40.1, abs=2.0)
    home = copter.autopilot.home.geodetic
    north = [waypoint(16, lat=home.latitude_deg, lon=home.longitude_deg + 4e-4, p4=0.0)]
    assert upload(copter, [waypoint(0), *north]) == mav.MAV_MISSION_ACCEPTED
    copter.send("MISSION_REQUEST_INT", 1, 1, 1)
    assert named(copter.step(2), "MISSION_ITEM_INT")[-1].param4 == 0.0
    assert set_mode(copter, AUTO) == 0
    copter.skip(4.0)
    assert math.degrees(copter.server._view.rpy_rad[2]) == pytest.approx(90.0, abs=5.0)


def test_one_setpoint_of_a_place_is_flown_to_without_a_stream(copter):
    fly(copter)
    copter.send("SET_POSITION_TARGET_LOCAL_NED", 0, 1, 1, 1, 0xDF8, 5.0, 0.0, -14.0, *[0.0] * 8)
    copter.skip(12.0)
    assert up_m(copter) == pytest.approx(14.0, abs=0.3)
    assert heartbeat(copter).custom_mode == GUIDED


def test_setpoints_of_velocity_are_followed_and_stop_three_seconds_after_the_last(copter):
    fly(copter)
    start_m = copter.plant.truth.position_enu_m[1]
    for _ in range(20):
        copter.send("SET_POSITION_TARGET_LOCAL_NED", 0, 1, 1, 1, 0xDC7, 0, 0, 0, 1.0, *[0.0] * 7)
        copter.skip(0.2)
    assert copter.autopilot.mode is Mode.OFFBOARD
    assert heartbeat(copter).custom_mode == GUIDED
    copter.skip(7.0)
    assert copter.autopilot.mode is Mode.HOLD
    assert 4.0 < copter.plant.truth.position_enu_m[1] - start_m < 11.0
    assert abs(copter.plant.truth.velocity_enu_mps[1]) < 0.1


def test_thrust_of_an_attitude_is_a_climb_that_takes_off_too(copter):
    guided_nogps, only_attitude = 20, 0b111

    def fly_attitude(thrust, seconds, q=(1.0, 0.0, 0.0, 0.0)):
        for _ in range(round(seconds / 0.2)):
            copter.send("SET_ATTITUDE_TARGET", 0, 1, 1, only_attitude, q, 0.0, 0.0, 0.0, thrust)
            copter.skip(0.2)

    copter.become_ready()
    assert set_mode(copter, guided_nogps) == 0
    assert copter.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    fly_attitude(0.5, 1.0)
    assert up_m(copter) < 0.5
    fly_attitude(0.7, 5.0)  # 0.4 of WPNAV_SPEED_UP, 1 m/s.
    assert heartbeat(copter).custom_mode == guided_nogps
    assert copter.plant.truth.velocity_enu_mps[2] == pytest.approx(1.0, abs=0.1)
    fly_attitude(0.5, 3.0)
    height_m, north_m = up_m(copter), copter.plant.truth.position_enu_m[1]
    assert height_m > 3.0
    half_pitch_rad = math.radians(-5.0) / 2  # Forward, with the nose to the north.
    fly_attitude(0.5, 3.0, (math.cos(half_pitch_rad), 0.0, math.sin(half_pitch_rad), 0.0))
    assert up_m(copter) == pytest.approx(height_m, abs=0.2)
    assert copter.plant.truth.velocity_enu_mps[1] > 1.5
    assert copter.plant.truth.position_enu_m[1] > north_m + 2.0


def test_nothing_of_it_moves_a_vehicle_on_the_ground(copter):
    copter.become_ready()
    assert copter.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    for _ in range(10):
        copter.send("SET_POSITION_TARGET_LOCAL_NED", 0, 1, 1, 1, 0xDF8, 5.0, 0.0, -14.0, *[0.0] * 8)
        copter.skip(0.2)
    assert copter.plant.truth.position_enu_m[2] < 0.5


def waypoint(command, lat=47.4, lon=8.5, z=10.0, **params):
    p = [params.get(f"p{i}", 0.0) for i in range(1, 5)]
    return [3, command, 0, 0, *p, round(lat * 1e7), round(lon * 1e7), z]


def upload(copter, items):
    copter.send("MISSION_COUNT", 1, 1, len(items))
    for _ in range(4 * len(items)):
        for message in copter.step():
            if message.get_type() == "MISSION_REQUEST":
                copter.send("MISSION_ITEM_INT", 1, 1, message.seq, *items[message.seq])
            if message.get_type() == "MISSION_ACK":
                return message.type
    raise AssertionError("no MISSION_ACK")


def test_home_is_item_0_of_the_mission_and_jumps_count_it(copter):
    copter.become_ready()
    items = [waypoint(16), waypoint(22), waypoint(16), waypoint(177, p1=2.0, p2=1.0)]
    assert upload(copter, items) == mav.MAV_MISSION_ACCEPTED
    stored = copter.autopilot.mission.items
    assert [item.command for item in stored] == [22, 16, 177]
    assert stored[2].param1 == 1.0
    assert all(item.is_autocontinue for item in stored)
    copter.send("MISSION_REQUEST_LIST", 1, 1)
    assert named(copter.step(2), "MISSION_COUNT")[-1].count == 4
    copter.send("MISSION_REQUEST_INT", 1, 1, 0)
    home = named(copter.step(2), "MISSION_ITEM_INT")[-1]
    place = copter.autopilot.home.geodetic
    assert home.x == pytest.approx(place.latitude_deg * 1e7, abs=1)
    assert home.z == pytest.approx(place.altitude_m, abs=0.01)
    copter.send("MISSION_REQUEST_INT", 1, 1, 3)
    jump = named(copter.step(2), "MISSION_ITEM_INT")[-1]
    assert (jump.command, jump.param1) == (177, 2.0)
    copter.send("MISSION_SET_CURRENT", 1, 1, 2)
    assert named(copter.step(2), "MISSION_CURRENT")[-1].seq == 2
    assert copter.autopilot.mission.current_index == 1


def test_a_jump_to_home_is_refused(copter):
    copter.become_ready()
    items = [waypoint(16), waypoint(22), waypoint(177, p1=0.0, p2=1.0)]
    assert upload(copter, items) != mav.MAV_MISSION_ACCEPTED


def test_parameters_have_ardupilots_names_units_and_encoding(copter):
    copter.send("PARAM_REQUEST_LIST", 1, 1)
    values = {m.param_id: m for m in named(copter.run(1.0), "PARAM_VALUE")}
    assert list(values) == sorted(p.name for p in (*ARDUPILOT.aliases, *ARDUPILOT.settings))
    assert values["RTL_ALT"].param_value == 1500.0  # cast, in cm
    assert values["RTL_ALT"].param_type == mav.MAV_PARAM_TYPE_INT32
    assert values["WPNAV_SPEED"].param_value == 1000.0
    copter.send("PARAM_SET", 1, 1, b"RTL_ALT", 2000.0, mav.MAV_PARAM_TYPE_INT32)
    assert named(copter.step(2), "PARAM_VALUE")[-1].param_value == 2000.0
    assert copter.autopilot.parameters["RTL_RETURN_ALT"] == 20.0


def test_a_choice_that_the_flight_stack_lacks_is_refused_with_those_it_has(copter):
    copter.send("PARAM_SET", 1, 1, b"FENCE_ACTION", 6.0, mav.MAV_PARAM_TYPE_INT8)
    text = "".join(m.text for m in named(copter.step(2), "STATUSTEXT"))
    assert "FENCE_ACTION = 6 is no choice; valid are 0, 1, 2, 3, 4, 5" in text
    copter.send("PARAM_SET", 1, 1, b"FENCE_ACTION", 1.0, mav.MAV_PARAM_TYPE_INT8)
    assert named(copter.step(2), "PARAM_VALUE")[-1].param_value == 1.0
    assert copter.autopilot.parameters["GF_ACTION"] == 3


def test_every_alias_reads_back_what_is_written_to_it(copter):
    for alias in ARDUPILOT.aliases:
        before = copter.autopilot.parameters[alias.ours]
        copter.send("PARAM_REQUEST_READ", 1, 1, alias.name.encode(), -1)
        told = named(copter.step(2), "PARAM_VALUE")[-1].param_value
        if alias.name == "SYSID_THISMAV":
            continue
        copter.send("PARAM_SET", 1, 1, alias.name.encode(), told, mav.MAV_PARAM_TYPE_REAL32)
        again = named(copter.step(2), "PARAM_VALUE")[-1].param_value
        assert again == struct.unpack("<f", struct.pack("<f", told))[0], alias.name
        assert copter.autopilot.parameters[alias.ours] == pytest.approx(before, rel=1e-5), alias


def test_px4_keeps_its_habits(flight):
    flight.become_ready()
    flight.run(1.1)
    assert flight.last("HEARTBEAT").autopilot == mav.MAV_AUTOPILOT_PX4
    flight.send("MISSION_REQUEST_LIST", 1, 1)
    assert named(flight.step(2), "MISSION_COUNT")[-1].count == 0
    assert flight.command(42428) == mav.MAV_RESULT_UNSUPPORTED


def test_the_banner_and_the_filters_status_are_ardupilots_own(copter):
    assert copter.command(42428) == 0
    copter.step()
    assert any("ArduCopter" in m.text for m in named(copter.heard, "STATUSTEXT"))
    copter.become_ready()
    copter.send("REQUEST_DATA_STREAM", 1, 1, mav.MAV_DATA_STREAM_ALL, 4, 1)
    raw = bytearray()
    for _ in range(60):
        copter.simulator.step()
        raw += copter.link.client.recv()
    from pymavlink.dialects.v20 import ardupilotmega

    decoder = ardupilotmega.MAVLink(None)
    heard = [m for m in decoder.parse_buffer(raw) or () if m.get_type() == "EKF_STATUS_REPORT"]
    assert heard[-1].flags & ardupilotmega.EKF_POS_HORIZ_ABS


def test_ground_truth_is_told_as_by_ardupilots_simulator(copter):
    from pymavlink.dialects.v20 import ardupilotmega

    copter.send("COMMAND_LONG", 1, 1, mav.MAV_CMD_REQUEST_MESSAGE, 0, 164, *(0.0,) * 6)
    copter.simulator.step()
    decoder = ardupilotmega.MAVLink(None)
    came = decoder.parse_buffer(copter.link.client.recv()) or ()
    (state,) = [m for m in came if m.get_type() == "SIMSTATE"]
    place = copter.frame.geodetic_from_enu(copter.plant.truth.position_enu_m)
    assert state.lat * 1e-7 == pytest.approx(place.latitude_deg, abs=1e-6)
    assert state.lng * 1e-7 == pytest.approx(place.longitude_deg, abs=1e-6)
    assert state.yaw == pytest.approx(math.pi / 2 - 0.7, abs=0.01)
    assert state.zacc == pytest.approx(-9.8, abs=0.5)


def test_raw_readings_come_unasked_as_scripts_for_copters_wait_for_them(copter):
    copter.become_ready()
    copter.run(1.0)
    raw = copter.last("RAW_IMU")
    assert (raw.xacc, raw.yacc, raw.zacc) == pytest.approx((0, 0, -1000), abs=60)
    assert (raw.xgyro, raw.ygyro, raw.zgyro) == pytest.approx((0, 0, 0), abs=60)
    field = math.hypot(raw.xmag, raw.ymag, raw.zmag)
    assert field == pytest.approx(480, abs=60)  # thousandths of a gauss, around Zurich
    before = len(named(copter.heard, "RAW_IMU"))
    copter.send("REQUEST_DATA_STREAM", 1, 1, mav.MAV_DATA_STREAM_RAW_SENSORS, 10, 1)
    copter.run(2.0)
    assert len(named(copter.heard, "RAW_IMU")) - before == pytest.approx(20, abs=2)


_FENCE_BIT = 1 << 20


def _reports_fence(flight):
    """Let the vehicle look at itself, and tell whether it says that its fence is on."""
    flight.run(2.0)
    return bool(flight.last("SYS_STATUS").onboard_control_sensors_enabled & _FENCE_BIT)


def test_copters_turn_their_fence_off_and_on(copter):
    assert not _reports_fence(copter)  # as long as there is none
    copter.autopilot.fence.replace([MissionItem(frame=3, command=5003, param1=9, x=47.4, y=8.5)])
    assert _reports_fence(copter)
    assert copter.command(mav.MAV_CMD_DO_FENCE_ENABLE, 0) == mav.MAV_RESULT_ACCEPTED
    assert not copter.autopilot.fence.is_enabled
    assert not _reports_fence(copter)
    assert copter.command(mav.MAV_CMD_DO_FENCE_ENABLE, 2) == mav.MAV_RESULT_FAILED  # no floor
    assert copter.command(mav.MAV_CMD_DO_FENCE_ENABLE, 3) == mav.MAV_RESULT_FAILED
    assert not copter.autopilot.fence.is_enabled
    assert copter.command(mav.MAV_CMD_DO_FENCE_ENABLE, 1) == mav.MAV_RESULT_ACCEPTED
    assert copter.autopilot.fence.is_enabled
    assert _reports_fence(copter)


def test_px4_does_not_know_how_to_turn_a_fence_off(flight):
    answer = flight.command(mav.MAV_CMD_DO_FENCE_ENABLE, 0)
    assert answer == mav.MAV_RESULT_UNSUPPORTED
    assert flight.autopilot.fence.is_enabled


def test_a_single_overridden_channel_flies_and_its_end_is_no_failsafe(copter):
    fly(copter)
    assert set_mode(copter, LOITER) == 0
    height_m = up_m(copter)
    copter.send("RC_CHANNELS_OVERRIDE", 1, 1, 0, 0, 1700, 0, 0, 0, 0, 0)
    copter.run(2.5)
    assert up_m(copter) > height_m + 1.0  # RC_OVERRIDE_TIME is 3 s.
    copter.skip(3.0)
    assert heartbeat(copter).custom_mode == LOITER
    assert copter.autopilot.failsafe is None
