"""ArduPilot's JSON physics: a step for every request, the state in its frames, bad packets."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flightsim.bridges.physics.ardupilot import PORT, ArduPilotBridge
from flightsim.bridges.physics.bridge import BridgeError
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.bridges.stand_in import StandIn
from tests.flightsim.handmade import empty_scene
from tests.instances import own_instance

YAW = 0.4
OFF = (1000,) * 4


@pytest.fixture(scope="module")
def world():
    return build_world(empty_scene(yaw_rad=YAW), airframe_by_name("iris"))


@pytest.fixture
def plant(world):
    return Plant(world, PlantCfg(seed=1, control_hz=500))


@pytest.fixture
def ends():
    bridge = ArduPilotBridge(own_instance())
    stand_in = StandIn(PORT + 10 * own_instance())
    yield bridge, stand_in
    bridge.close()
    stand_in.close()


def exchange(plant, bridge, stand_in, pulses=OFF):
    """One step: the outputs that the bridge understood, and the state that came back."""
    stand_in.ask(pulses)
    outputs = bridge.receive(5.0)
    plant.advance()
    bridge.send_state(plant)
    return outputs, stand_in.take()


def test_every_request_is_one_step_and_one_answer(plant, ends):
    bridge, stand_in = ends
    assert bridge.receive(0.01) is None
    bridge.send_state(plant)
    assert stand_in.is_quiet()  # Nobody has asked.
    times = [exchange(plant, bridge, stand_in)[1]["timestamp"] for _ in range(20)]
    assert times == pytest.approx(0.02 * np.arange(1, 21))
    assert stand_in.is_quiet()


def test_a_repeated_request_gets_its_answer_again_without_a_step(plant, ends):
    bridge, stand_in = ends
    _, state = exchange(plant, bridge, stand_in)
    stand_in.count -= 1
    stand_in.ask()  # as if the answer had been lost
    assert bridge.receive(1.0) is None
    assert stand_in.take() == state
    outputs, after = exchange(plant, bridge, stand_in)
    assert outputs is not None
    assert after["timestamp"] == pytest.approx(state["timestamp"] + 0.02)


def test_pulses_become_shares_of_full_output(plant, ends):
    outputs, _ = exchange(plant, *ends, pulses=(1000, 1250, 1500, 2000))
    assert outputs == pytest.approx((0.0, 0.25, 0.5, 1.0))


def test_the_state_is_ned_and_frd_from_where_the_vehicle_was(plant, ends):
    bridge, stand_in = ends
    bridge.send_state(plant)  # Here the origin is.
    away_enu_m, rate_flu = np.array([3.0, 5.0, 2.0]), (0.1, 0.2, 0.3)
    enu_from_flu = Rotation.from_euler("ZYX", (0.9, -0.2, 0.1))
    plant.data.qpos[:3] += away_enu_m
    plant.data.qpos[3:7] = enu_from_flu.as_quat(scalar_first=True)
    plant.data.qvel[:] = (1.0, 2.0, -0.5, *rate_flu)
    stand_in.ask()
    bridge.receive(5.0)
    plant._read_afresh()
    bridge.send_state(plant)
    state = stand_in.take()
    assert state["position"] == pytest.approx((5.0, 3.0, -2.0), abs=1e-5)
    assert state["velocity"] == pytest.approx((2.0, 1.0, 0.5), abs=1e-5)
    ned_from_enu = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
    expected = ned_from_enu @ enu_from_flu.as_matrix() @ np.diag((1, -1, -1))
    said = Rotation.from_quat(state["quaternion"], scalar_first=True).as_matrix()
    assert said == pytest.approx(expected, abs=1e-7)


def test_at_rest_the_accelerometer_feels_gravity_upwards(plant, ends):
    for _ in range(3):
        _, state = exchange(plant, *ends)
    assert state["imu"]["accel_body"] == pytest.approx((0.0, 0.0, -9.81), abs=0.6)
    assert np.linalg.norm(state["imu"]["gyro"]) < 0.1
    assert state["battery"]["voltage"] == pytest.approx(12.5, abs=0.3)
    assert 0.0 < state["rng_1"] < 0.3


@pytest.mark.parametrize("data", [b"hello", bytes(40), bytes(72)])
def test_a_malformed_packet_is_said_once_and_costs_nothing(plant, ends, data):
    bridge, stand_in = ends
    for _ in range(2):
        stand_in.send(data)
        assert bridge.receive(1.0) is None
    (line,) = bridge.notices
    assert f"{len(data)} bytes" in line
    assert "valid: 40 with 18458 or 72 with 29569" in line
    assert exchange(plant, bridge, stand_in)[0] is not None


def test_thirty_two_channels_are_understood(plant, ends):
    bridge, stand_in = ends
    pulses = (1100, 1200, 1300, 1400, *(0,) * 28)
    widths = b"".join(pulse.to_bytes(2, "little") for pulse in pulses)
    stand_in.send((29569).to_bytes(2, "little") + bytes((0, 2)) + bytes(4) + widths)
    assert bridge.receive(1.0) == pytest.approx((0.1, 0.2, 0.3, 0.4))


def test_a_stack_that_begins_anew_is_noticed_and_served(plant, ends):
    bridge, stand_in = ends
    for _ in range(5):
        exchange(plant, bridge, stand_in)
    stand_in.count = 0
    outputs, state = exchange(plant, bridge, stand_in)
    assert outputs is not None
    assert state["timestamp"] == pytest.approx(0.12)
    assert bridge.n_restarts == 1
    assert "begun anew" in bridge.notices[0]


def test_a_taken_port_is_one_clear_line(ends):
    with pytest.raises(BridgeError, match=r"UDP port \d+ .* is taken; valid: another --instance"):
        ArduPilotBridge(own_instance())


def test_nothing_beyond_reach_is_no_number_that_json_lacks(plant, ends):
    plant._record["range"]["range_m"] = math.inf
    bridge, stand_in = ends
    stand_in.ask()
    bridge.receive(5.0)
    bridge.send_state(plant)
    assert stand_in.take()["rng_1"] > 100.0


def test_what_passes_in_lockstep_is_counted(plant, ends):
    bridge, stand_in = ends
    for _ in range(3):
        exchange(plant, bridge, stand_in)
    assert bridge.exchanges.is_whole
    stand_in.count -= 1
    stand_in.ask()  # again
    assert bridge.receive(1.0) is None
    stand_in.take()
    stand_in.count += 2
    exchange(plant, bridge, stand_in)
    count = bridge.exchanges
    assert (count.told, count.answered, count.unanswered) == (4, 4, 0)
    assert (count.repeated, count.left_out) == (1, 2)
    assert not count.is_whole
