"""PX4's simulator link: lockstep, sensors in its units, and what is wrong said once."""

import math
import socket

import numpy as np
import pytest

from flightsim.bridges.launch.launch import Start
from flightsim.bridges.launch.px4 import launch, parameter_file, parameters, sensor_parameters
from flightsim.bridges.physics.bridge import BridgeError
from flightsim.bridges.physics.px4 import PORT, Px4Bridge
from flightsim.environment.atmosphere import AIR_DENSITY_KGPM3
from flightsim.frames import Geodetic, LocalFrame, swap_flu_frd
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.plant import Plant, PlantCfg
from flightsim.sensors.optical_flow import OpticalFlowCfg
from flightsim.vehicles import airframe_by_name
from flightsim.vehicles.air.frame import frame_drag
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene
from tests.instances import own_instance

QUADROTORS = [name for name, a in AIRFRAMES.items() if len(a.quadrotor.rotors) == 4]
ZURICH = Geodetic(47.4, 8.5, 488.0)
ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
LOCKSTEP = 1
YAW = 0.4


class StandIn:
    """A stand-in for PX4, for tests alone: it answers samples with the outputs that it is told."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=20.0)
        self._mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def take(self, until="HIL_SENSOR"):
        """Messages up to the next of a kind."""
        taken = []
        while not taken or taken[-1].get_type() != until:
            taken += self._mav.parse_buffer(self.socket.recv(1 << 16)) or ()
        return {message.get_type(): message for message in taken}

    def answer(self, time_us, controls, mode=ARMED, flags=LOCKSTEP):
        message = mavlink.MAVLink_hil_actuator_controls_message(
            time_us, (*controls, *(0.0,) * (16 - len(controls))), mode, flags
        )
        self.socket.sendall(message.pack(self._mav))

    def close(self):
        self.socket.close()


def start_with(*, is_in_room=False, **sensors):
    """A start in Zurich with these sensors."""
    cfg = PlantCfg(seed=1, **sensors)
    return Start(place=ZURICH, heading_deg=0.0, sensors=cfg, is_in_room=is_in_room)


@pytest.fixture(scope="module")
def world():
    return build_world(empty_scene(yaw_rad=YAW), airframe_by_name("iris"))


@pytest.fixture
def plant(world):
    return Plant(world, PlantCfg(seed=1))


@pytest.fixture
def bridge():
    bridge = Px4Bridge(own_instance(), LocalFrame(ZURICH))
    yield bridge
    bridge.close()


@pytest.fixture
def stand_in(bridge):
    stand_in = StandIn(PORT + own_instance())
    assert bridge.connect(5.0)
    yield stand_in
    stand_in.close()


def test_nobody_is_there_at_first(bridge):
    assert not bridge.connect(0.01)


def test_time_passes_by_the_wall_clock_until_px4_answers_and_then_by_its_answers(
    plant, bridge, stand_in
):
    bridge.send_state(plant)
    assert bridge.receive(1.0) == (0.0, 0.0, 0.0, 0.0)
    bridge.send_state(plant)
    sensor = stand_in.take()["HIL_SENSOR"]
    stand_in.answer(sensor.time_usec, (0.1, 0.2, 0.3, 0.4))
    assert bridge.receive(1.0) == pytest.approx((0.1, 0.2, 0.3, 0.4))
    plant.advance()
    bridge.send_state(plant)
    assert bridge.receive(0.05) is None  # It waits.
    stand_in.answer(sensor.time_usec, (0.9,) * 4)  # to the step before, once more
    assert bridge.receive(0.05) is None
    after = stand_in.take()["HIL_SENSOR"]
    assert after.time_usec == sensor.time_usec + 20_000
    stand_in.answer(after.time_usec, (0.5,) * 4)
    assert bridge.receive(1.0) == pytest.approx((0.5,) * 4)


def test_disarmed_outputs_are_off(plant, bridge, stand_in):
    bridge.send_state(plant)
    time_us = stand_in.take()["HIL_SENSOR"].time_usec
    stand_in.answer(time_us, (0.5, math.nan, 0.5, 0.5), mode=0)
    assert bridge.receive(1.0) == (0.0,) * 4
    bridge.send_state(plant)
    stand_in.answer(time_us, (0.5, math.nan, 0.5, 0.5))
    assert bridge.receive(1.0) == (0.5, 0.0, 0.5, 0.5)


def test_samples_come_in_the_units_and_frames_of_px4(plant, bridge, stand_in):
    for _ in range(50):
        plant.advance()
    bridge.send_state(plant)
    told = stand_in.take()
    sensor, gps, state = told["HIL_SENSOR"], told["HIL_GPS"], told["HIL_STATE_QUATERNION"]
    assert sensor.id == 0
    assert sensor.fields_updated == 0x1BFF
    assert sensor.zacc == pytest.approx(-9.81, abs=0.5)
    assert (sensor.xgyro, sensor.ygyro, sensor.zgyro) == pytest.approx(
        swap_flu_frd(plant.sensors.imu.gyro_flu_radps), abs=1e-7
    )
    assert 0.0 not in {sensor.xgyro, sensor.ygyro, sensor.zgyro}
    field = (sensor.xmag, sensor.ymag, sensor.zmag)
    assert field == pytest.approx((0.091, -0.195, 0.428), abs=0.03)  # gauss
    assert sensor.abs_pressure == pytest.approx(956.0, abs=15.0)
    assert (gps.lat, gps.lon) == pytest.approx((474_000_000, 85_000_000), abs=200)
    assert gps.fix_type >= 3
    assert gps.satellites_visible > 5
    assert state.alt == pytest.approx(1e3 * (488.0 + plant.truth.position_enu_m[2]), abs=2)
    assert np.linalg.norm(state.attitude_quaternion) == pytest.approx(1.0)
    assert 0 < told["DISTANCE_SENSOR"].current_distance < 30
    # A sample that has been sent is not sent as a new one.
    bridge.send_state(plant)
    again = stand_in.take()
    assert again["HIL_SENSOR"].fields_updated == 0b111111
    assert "HIL_GPS" not in again


def test_answers_are_read_in_pieces_and_beside_other_messages(plant, bridge, stand_in):
    parser = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    heartbeat = mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 0, 3).pack(parser)
    for level, (before, cut) in enumerate(((b"", 0), (heartbeat, 0), (b"", 5), (heartbeat, 30))):
        bridge.send_state(plant)
        time_us = stand_in.take()["HIL_SENSOR"].time_usec
        controls = (0.1 * level,) * 4 + (0.0,) * 12
        answer = mavlink.MAVLink_hil_actuator_controls_message(time_us, controls, ARMED, LOCKSTEP)
        data = before + answer.pack(parser)
        stand_in.socket.sendall(data[:cut])
        if cut:
            assert bridge.receive(0.05) is None
        stand_in.socket.sendall(data[cut:])
        assert bridge.receive(1.0) == pytest.approx((0.1 * level,) * 4)
        plant.advance()
    assert bridge.exchanges.left_out == bridge.exchanges.repeated == 0


def test_nobody_else_takes_the_place_of_a_px4_that_answers(plant, bridge, stand_in):
    bridge.send_state(plant)
    stand_in.answer(stand_in.take()["HIL_SENSOR"].time_usec, (0.5,) * 4)
    assert bridge.receive(1.0) is not None
    plant.advance()
    bridge.send_state(plant)
    for _ in range(2):
        with socket.create_connection(("127.0.0.1", PORT + own_instance()), timeout=5.0) as other:
            assert bridge.receive(0.2) is None
            assert other.recv(1) == b""  # closed
    stand_in.answer(stand_in.take()["HIL_SENSOR"].time_usec, (0.6,) * 4)
    assert bridge.receive(1.0) == pytest.approx((0.6,) * 4)
    assert bridge.n_restarts == 0
    assert len(bridge.notices) == 1
    assert "a second connection" in bridge.notices[0]


def test_px4_that_begins_anew_is_served(plant, bridge, stand_in):
    bridge.send_state(plant)
    stand_in.answer(stand_in.take()["HIL_SENSOR"].time_usec, (0.5,) * 4)
    assert bridge.receive(1.0) is not None
    stand_in.close()
    bridge.send_state(plant)
    assert bridge.receive(0.1) is None
    second = StandIn(PORT + own_instance())
    assert bridge.receive(1.0) is not None  # off, while it starts
    bridge.send_state(plant)
    second.answer(second.take()["HIL_SENSOR"].time_usec, (0.7,) * 4)
    assert bridge.receive(1.0) == pytest.approx((0.7,) * 4)
    assert bridge.n_restarts == 1
    assert "begun anew" in bridge.notices[0]
    second.close()


def test_no_lockstep_and_no_mavlink_are_each_said_once(plant, bridge, stand_in):
    for _ in range(2):
        bridge.send_state(plant)
        stand_in.socket.sendall(b"GET / HTTP/1.1\r\n\r\n")
        stand_in.answer(stand_in.take()["HIL_SENSOR"].time_usec, (0.5,) * 4, flags=0)
        assert bridge.receive(1.0) == (0.5,) * 4
    assert len(bridge.notices) == 2
    assert "are ignored; valid: the simulator link of PX4" in bridge.notices[0]
    assert "without lockstep" in bridge.notices[1]


def test_a_taken_port_is_one_clear_line(bridge):
    with pytest.raises(BridgeError, match=r"TCP port \d+ .* is taken; valid: another --instance"):
        Px4Bridge(own_instance(), LocalFrame(ZURICH))


@pytest.mark.parametrize("name", QUADROTORS)
def test_the_mixer_of_px4_has_our_rotors_in_its_order_and_axes(name):
    airframe, p = AIRFRAMES[name], parameters(AIRFRAMES[name])
    quadrotor = airframe.quadrotor
    for motor, rotor in enumerate(airframe.motors):
        x, y, _ = quadrotor.rotors[rotor].position_flu_m
        assert (p[f"CA_ROTOR{motor}_PX"], p[f"CA_ROTOR{motor}_PY"]) == (x, -y)
        # Counter-clockwise ones turn the body clockwise, which PX4 counts as positive.
        assert p[f"CA_ROTOR{motor}_KM"] == pytest.approx(
            quadrotor.rotors[rotor].spin * quadrotor.rotors[rotor].torque_per_thrust_m
        )
        assert p[f"PWM_MAIN_FUNC{motor + 1}"] == 101 + motor
    moments = [p[f"CA_ROTOR{k}_KM"] > 0 for k in range(4)]
    assert moments == [True, True, False, False]
    assert p["MPC_THR_HOVER"] == pytest.approx(quadrotor.hover_thrust_fraction)
    script = parameter_file(airframe, start_with()).splitlines()
    assert script[0] == "#!/bin/sh"
    assert all(line.startswith("param set ") for line in script[2:])


@pytest.mark.parametrize("name", QUADROTORS)
def test_ekf2_finds_the_wind_by_the_air_resistance_that_the_physics_has(name):
    airframe, p = AIRFRAMES[name], parameters(AIRFRAMES[name])
    rotors, wind_mps = airframe.quadrotor.rotors, 6.0
    hover_radps = airframe.quadrotor.hover_speed_radps
    for axis, along in zip((0, 1), "XY", strict=True):
        frame_n = frame_drag(airframe, has_arms=True)[axis] * wind_mps**2
        rotors_n = sum(rotor.drag_coefficient for rotor in rotors) * hover_radps * wind_mps
        expected = 0.5 * AIR_DENSITY_KGPM3 / p[f"EKF2_BCOEF_{along}"] * wind_mps**2
        expected += p["EKF2_MCOEF"] * wind_mps
        assert expected * airframe.quadrotor.mass_kg == pytest.approx(frame_n + rotors_n)
    assert p["EKF2_DRAG_CTRL"] == 1


def test_until_it_has_taken_off_it_may_lean_against_wind_of_six_metres_a_second():
    p = parameters(AIRFRAMES["iris"])
    push_mps2 = 0.5 * AIR_DENSITY_KGPM3 / p["EKF2_BCOEF_X"] * 36.0 + p["EKF2_MCOEF"] * 6.0
    assert math.tan(math.radians(p["MPC_TILTMAX_LND"])) * 9.81 > 1.5 * push_mps2
    # PX4 lowers the greater one by itself, with an error in its log.
    assert 0.25 < p["LNDMC_Z_VEL_MAX"] <= p["MPC_LAND_CRWL"] / 1.2


def test_px4_that_we_start_keeps_no_logs_since_they_would_go_with_its_folder(tmp_path):
    for binary in (None, tmp_path / "bin" / "px4"):
        launch(AIRFRAMES["iris"], start_with(), 3, tmp_path, binary)
        script = (tmp_path / "px4-rc.params").read_text().splitlines()
        assert ("param set SDLOG_MODE -1" in script) == (binary is not None)
    links = (tmp_path / "px4-rc.mavlink").read_text().splitlines()
    assert [line for line in links if "stop" in line] == [
        "mavlink stop -u $((14280+px4_instance))",
        "mavlink stop -u $((13030+px4_instance))",
    ]


def test_what_passes_in_lockstep_is_counted(plant, bridge, stand_in):
    bridge.send_state(plant)
    assert bridge.receive(1.0) == (0.0,) * 4  # It starts.
    bridge.send_state(plant)
    time_us = stand_in.take()["HIL_SENSOR"].time_usec
    for _ in range(2):
        stand_in.answer(time_us, (0.5,) * 4)
    assert bridge.receive(1.0) is not None
    plant.advance()
    bridge.send_state(plant)
    stand_in.answer(time_us, (0.5,) * 4)  # late
    stand_in.answer(time_us + 40_000, (0.5,) * 4)  # of a step that has not been
    assert bridge.receive(1.0) is not None
    count = bridge.exchanges
    assert (count.told, count.answered, count.unanswered) == (3, 2, 1)
    assert (count.repeated, count.left_out) == (2, 1)
    assert not count.is_whole


def test_the_estimator_of_px4_is_told_what_there_is_to_fuse():
    outside = sensor_parameters(start_with(aiding="auto"))
    assert (outside["EKF2_GPS_CTRL"], outside["EKF2_EV_CTRL"], outside["EKF2_HGT_REF"]) == (
        7,
        3,
        1,
    )
    assert (outside["EKF2_EV_DELAY"], outside["EKF2_GPS_DELAY"]) == pytest.approx((40.0, 120.0))
    inside = sensor_parameters(start_with(aiding="auto", is_in_room=True))
    assert (inside["EKF2_EV_CTRL"], inside["EKF2_HGT_REF"]) == (11, 3)
    satellites = sensor_parameters(start_with(aiding="gnss", is_in_room=True))
    assert (satellites["EKF2_EV_CTRL"], satellites["EKF2_HGT_REF"]) == (0, 1)
    odometry = sensor_parameters(start_with(aiding="vio"))
    assert (odometry["SYS_HAS_GPS"], odometry["EKF2_GPS_CTRL"]) == (0, 0)
    assert (odometry["EKF2_EV_CTRL"], odometry["EKF2_HGT_REF"]) == (11, 3)
    assert (odometry["EKF2_OF_CTRL"], outside["EKF2_OF_CTRL"]) == (0, 0)
    eye = OpticalFlowCfg(is_fitted=True)
    assert sensor_parameters(start_with(optical_flow=eye))["EKF2_OF_CTRL"] == 1
