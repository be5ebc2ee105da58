"""What the vehicle tells is what its estimator, sensors and autopilot say."""

import math
from types import SimpleNamespace

import pytest
from pymavlink import mavutil

from flightsim.autopilot.modes import Mode
from flightsim.environment.movers import MovingObstacle
from flightsim.environment.wind import WindCfg
from flightsim.frames import Geodetic
from flightsim.mavlink.dialect import LAYOUTS, layout
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.links import InProcessLink
from flightsim.mavlink.personalities import PX4
from flightsim.mavlink.server import MavlinkServer
from flightsim.mavlink.telemetry_sensors import imu_fields
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.mavlink.conftest import START_ENU_M, Flight
from tests.flightsim.mavlink.wire import Wire, named


def test_a_heartbeat_comes_every_second_from_the_autopilot_component(flight):
    heartbeats = named(flight.run(10.0), "HEARTBEAT")
    assert len(heartbeats) == 10
    heartbeat = heartbeats[-1]
    assert (heartbeat.get_srcSystem(), heartbeat.get_srcComponent()) == (1, 1)
    assert (heartbeat.type, heartbeat.autopilot, heartbeat.system_status) == (2, 12, 3)
    assert heartbeat.base_mode & 1
    assert not heartbeat.base_mode & 128


def test_nothing_is_told_of_position_before_the_estimator_knows_it(flight):
    came = flight.run(0.1)
    assert not named(came, "LOCAL_POSITION_NED")
    assert not named(came, "GLOBAL_POSITION_INT")
    flight.become_ready()
    assert named(flight.run(0.1), "LOCAL_POSITION_NED")


def test_the_local_frame_begins_where_the_vehicle_stands(flight):
    flight.become_ready()
    flight.run(1.0)
    local = flight.last("LOCAL_POSITION_NED")
    assert max(abs(local.x), abs(local.y), abs(local.z)) < 0.6
    flight.command(mav.MAV_CMD_REQUEST_MESSAGE, LAYOUTS["GPS_GLOBAL_ORIGIN"].message_id)
    origin = flight.last("GPS_GLOBAL_ORIGIN")
    place = Geodetic(origin.latitude * 1e-7, origin.longitude * 1e-7, origin.altitude * 1e-3)
    assert flight.frame.enu_from_geodetic(place)[:2] == pytest.approx(START_ENU_M[:2], abs=0.02)


def test_the_messages_of_a_tick_agree_with_the_estimate(flight):
    flight.take_off()
    # Sideways, so that nothing is zero.
    flight.command_int(
        mav.MAV_CMD_DO_REPOSITION, 6, -1, 1, 0, math.nan, round(47.40012e7), round(8.50012e7), 12.0
    )
    flight.run(2.0)
    flight.heard.clear()
    flight.run_until(
        lambda: (
            {"ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "ATTITUDE_QUATERNION"}
            <= {message.get_type() for message in flight.step()}
        )
    )
    state = flight.plant.estimate
    local = flight.last("LOCAL_POSITION_NED")
    east, north, up = state.velocity_enu_mps
    assert (local.vx, local.vy, local.vz) == pytest.approx((north, east, -up), abs=1e-5)
    assert local.time_boot_ms == state.time_us // 1000
    whole = flight.last("GLOBAL_POSITION_INT")
    place = flight.frame.geodetic_from_enu(state.position_enu_m)
    assert whole.lat == pytest.approx(place.latitude_deg * 1e7, abs=1)
    assert whole.lon == pytest.approx(place.longitude_deg * 1e7, abs=1)
    assert whole.vx == pytest.approx(100 * north, abs=1)
    attitude = flight.last("ATTITUDE")
    w, x, y, z = state.quat_wxyz
    yaw_enu = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    assert math.cos(attitude.yaw - (math.pi / 2 - yaw_enu)) == pytest.approx(1.0, abs=1e-6)
    assert attitude.rollspeed == pytest.approx(state.angular_rate_flu_radps[0], abs=1e-6)
    assert attitude.pitchspeed == pytest.approx(-state.angular_rate_flu_radps[1], abs=1e-6)
    quaternion = flight.last("ATTITUDE_QUATERNION")
    norm = math.hypot(quaternion.q1, quaternion.q2, quaternion.q3, quaternion.q4)
    assert norm == pytest.approx(1.0, abs=1e-6)


def test_the_imu_feels_gravity_upwards_in_frd(flight):
    flight.become_ready()
    flight.run(0.1)
    imu = flight.last("HIGHRES_IMU")
    assert imu.zacc == pytest.approx(-9.8, abs=0.6)
    assert imu.abs_pressure == pytest.approx(955.0, abs=10.0)
    assert imu.zmag > 0.2  # the field points down in the north


def test_the_wind_from_ahead_reaches_the_messages_of_the_airspeed_sensor(flight):
    flight.become_ready()
    truth = LAYOUTS["HIL_STATE_QUATERNION"].message_id
    assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, truth, 100_000) == 0
    w, x, y, z = flight.plant.truth.quat_wxyz
    forward = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z))
    flight.plant.wind = WindCfg.towards((-8.0 * forward[0], -8.0 * forward[1], 0.0))
    flight.run(1.1)
    for message in (flight.last("HIGHRES_IMU"), flight.last("SCALED_PRESSURE")):
        pressure_hpa = getattr(message, "diff_pressure", None) or message.press_diff
        assert 100.0 * pressure_hpa == pytest.approx(0.5 * 1.17 * 64.0, abs=5.0)
    # 8 m/s in air of 1.17 kg/m^3
    assert flight.last("VFR_HUD").airspeed == pytest.approx(7.8, abs=0.4)
    assert flight.last("VFR_HUD").groundspeed < 0.5
    assert flight.last("HIL_STATE_QUATERNION").true_airspeed == pytest.approx(800, abs=10)
    assert flight.last("HIGHRES_IMU").fields_updated == 0x1FFF
    assert flight.last("SCALED_PRESSURE").temperature_press_diff == pytest.approx(1183, abs=5)


def test_health_bits_let_clients_arm(flight):
    flight.become_ready()
    flight.run(1.0)
    status = flight.last("SYS_STATUS")
    needed = 1 | 2 | 4 | 32 | 1 << 28
    assert status.onboard_control_sensors_health & needed == needed
    assert status.voltage_battery > 10_000
    battery = flight.last("BATTERY_STATUS")
    assert sum(cell for cell in battery.voltages if cell != 0xFFFF) == pytest.approx(
        status.voltage_battery, abs=60
    )
    assert flight.last("GPS_RAW_INT").fix_type >= 3


def test_a_flight_is_told_from_takeoff_to_landing(flight):
    flight.take_off(5.0)
    flight.run(1.0)
    assert flight.last("HEARTBEAT").base_mode & 128
    assert flight.last("HEARTBEAT").system_status == 4
    assert flight.last("EXTENDED_SYS_STATE").landed_state in {2, 3}
    assert (
        min(getattr(flight.last("SERVO_OUTPUT_RAW"), f"servo{i}_raw") for i in range(1, 5)) > 1300
    )
    assert flight.last("VFR_HUD").throttle > 30
    assert flight.last("ALTITUDE").altitude_relative == pytest.approx(5.0, abs=0.6)
    assert flight.last("DISTANCE_SENSOR").current_distance == pytest.approx(500, abs=70)
    assert flight.command(mav.MAV_CMD_NAV_LAND, *(math.nan,) * 7) == 0
    flight.run_until(lambda: not flight.autopilot.is_armed)
    flight.run(1.1)
    assert flight.last("EXTENDED_SYS_STATE").landed_state == 1
    assert named(flight.heard, "STATUSTEXT")[0].text == "Armed by external command"


def test_ground_truth_comes_only_when_asked_for(flight):
    ground_truth = LAYOUTS["HIL_STATE_QUATERNION"].message_id
    assert not named(flight.run(1.0), "HIL_STATE_QUATERNION")
    assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, ground_truth, 100_000) == 0
    came = named(flight.run(2.0), "HIL_STATE_QUATERNION")
    assert len(came) == 20
    place = flight.frame.geodetic_from_enu(flight.plant.truth.position_enu_m)
    assert came[-1].lat == pytest.approx(place.latitude_deg * 1e7, abs=1)


def test_the_wind_the_sticks_and_the_motors_are_told(flight):
    flight.plant.wind = WindCfg.towards((4.0, 0.0, 0.0))
    flight.take_off(4.0)
    for _ in range(60):
        flight.send("MANUAL_CONTROL", 1, 500, -250, 750, 0, 0)
        flight.step(5)
    wind = flight.last("WIND_COV")
    assert (wind.wind_x, wind.wind_y) == pytest.approx((0.0, 4.0), abs=1.5)
    sticks = flight.last("RC_CHANNELS")
    assert (sticks.chan1_raw, sticks.chan2_raw, sticks.chan3_raw) == (1375, 1250, 1750)
    assert (sticks.chan4_raw, sticks.chan5_raw, sticks.chancount) == (1500, 0xFFFF, 4)


def test_other_drones_report_themselves_and_nothing_else_does(field, flight):
    assert not named(flight.run(1.0), "ADSB_VEHICLE")
    assert not flight.server.telemetry.is_known(mav.MAVLINK_MSG_ID_ADSB_VEHICLE)
    movers = [
        MovingObstacle(
            kind=kind, path_enu_m=((20.0, 0.0, height_m), (60.0, 0.0, height_m)), speed_mps=2.0
        )
        for kind, height_m in (("person", 0.0), ("drone", 5.0), ("drone", 9.0))
    ]
    other = Flight(build_world(field.scene, AIRFRAMES["iris"], traffic=movers))
    other.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    came = named(other.run(2.0), "ADSB_VEHICLE")
    assert {m.callsign for m in came} == {"DRONE0", "DRONE1"}
    assert len({m.ICAO_address for m in came}) == 2
    states = other.plant.obstacles_true
    place = other.frame.geodetic_from_enu(tuple(states.position_enu_m[1].tolist()))
    report = [m for m in came if m.callsign == "DRONE0"][-1]
    assert (report.lat * 1e-7, report.lon * 1e-7) == pytest.approx(
        (place.latitude_deg, place.longitude_deg), abs=3e-5
    )
    assert report.altitude * 1e-3 == pytest.approx(place.altitude_m, abs=0.1)
    assert report.hor_velocity == pytest.approx(200, abs=5)
    other.server.close()


def test_each_client_has_its_own_rates(field):
    flight = Flight(field)
    links = [InProcessLink(), InProcessLink(profile="normal")]
    server = MavlinkServer(flight.autopilot, flight.plant, flight.frame, links)
    wires = [Wire(), Wire()]
    imu = LAYOUTS["HIGHRES_IMU"].message_id
    links[0].client.send(
        wires[0].encode(
            "COMMAND_LONG", 1, 1, mav.MAV_CMD_SET_MESSAGE_INTERVAL, 0, imu, 200_000, 0, 0, 0, 0, 0
        )
    )
    links[1].client.recv()
    counts = [0, 0]
    for _ in range(250):
        flight.plant.advance()
        flight.autopilot.update()
        server.update()
        for index, (link, wire) in enumerate(zip(links, wires, strict=True)):
            counts[index] += len(named(wire.decode(link.client.recv()), "HIGHRES_IMU"))
    assert counts == [25, 10]
    server.close()
    flight.server.close()


@pytest.mark.parametrize("mode", list(Mode))
def test_every_mode_is_one_that_pymavlink_can_name(mode):
    entry = PX4.entry(mode)
    name = mavutil.interpret_px4_mode(entry.base_mode, entry.custom_mode)
    assert name != "UNKNOWN"
    if entry.is_selectable:
        assert PX4.selectable(entry.custom_mode) is entry


def test_an_estimate_that_is_no_number_ends_nothing(flight):
    flight.become_ready()
    estimate = flight.plant.filter["position_enu_m"]
    came = []
    for _ in range(100):
        flight.plant.advance()
        flight.autopilot.update()
        kept = estimate.copy()
        estimate[:] = (math.nan, math.inf, 1e300)
        flight.server.update()
        estimate[:] = kept  # The filter goes on from what it knew.
        came += flight.wire.decode(flight.link.client.recv())
    assert named(came, "HEARTBEAT")
    assert not named(came, "GLOBAL_POSITION_INT")
    assert named(came, "ATTITUDE")
    assert flight.server.faults.n_caught == 0


def test_scaled_readings_come_on_request(flight):
    flight.become_ready()
    imu_id = LAYOUTS["SCALED_IMU"].message_id
    assert not named(flight.heard, "SCALED_IMU")
    assert flight.command(mav.MAV_CMD_REQUEST_MESSAGE, imu_id) == mav.MAV_RESULT_ACCEPTED
    assert flight.last("SCALED_IMU").zacc == pytest.approx(-1000, abs=60)


def test_readings_beyond_a_field_are_the_nearest_that_it_holds():
    imu = SimpleNamespace(accel_flu_mps2=(1e6, -1e6, -9.80665), gyro_flu_radps=(0.5, 0.0, 1e9))
    mag, baro = SimpleNamespace(field_flu_ut=(20.0, 0.0, 1e9)), SimpleNamespace(temperature_degc=15)
    sensors = SimpleNamespace(imu=imu, mag=mag, baro=baro)
    fields = imu_fields(SimpleNamespace(plant=SimpleNamespace(sensors=sensors)))
    assert (fields["xacc"], fields["yacc"], fields["zacc"]) == (32767, 32767, 1000)
    assert (fields["xgyro"], fields["zgyro"], fields["zmag"]) == (500, -32767, -32767)
    assert layout("SCALED_IMU").encode(time_boot_ms=0, **fields)
