"""The companion's client against the real autopilot and MAVLink server, over a pipe that fails."""

import math

import pytest

from autonomy.types import FlatReference
from flightsim.autopilot.events import Severity
from flightsim.mavlink.client import PX4_HOLD, PX4_OFFBOARD, CommandState, MavlinkClient
from flightsim.mavlink.client.telemetry import LANDED_ON_GROUND
from flightsim.mavlink.dialect import dialect as mav
from flightsim.testbench import Testbench, TestbenchCfg
from tests.scenarios.landing_scenes import yard


class LossyPipe:
    """The in-process link, losing the frames numbered in `loses`, counted from 0."""

    def __init__(self, pipe, loses=frozenset()):
        self._pipe, self._loses = pipe, loses
        self.n_sent = 0

    def send(self, data):
        self.n_sent += 1
        if self.n_sent - 1 not in self._loses:
            self._pipe.send(data)

    def recv(self):
        return self._pipe.recv()


class Flight:
    """A testbench and a client in lockstep."""

    def __init__(self, loses=frozenset()):
        self.bench = Testbench(yard(), TestbenchCfg(speed="max"), has_network=False)
        self.bench.observers.append(self._on_tick)
        self.pipe = LossyPipe(self.bench.stack.pipe(), loses)
        self.client = MavlinkClient(self.pipe, self.bench.frame)
        self.reference = None

    def _on_tick(self):
        self.client.update(self.bench.plant.time_us)
        if self.reference is not None:
            self.client.send_setpoint(self.reference)

    def run(self, seconds, until=lambda: False):
        self.bench.run(seconds, until)

    def do(self, command):
        self.run(10.0, lambda: command.is_done)
        return command


@pytest.fixture
def flight():
    made = []

    def make(**options):
        made.append(Flight(**options))
        return made[-1]

    yield make
    for each in made:
        each.bench.close()


def connected(flight):
    for command in flight.client.request_streams():
        assert flight.do(command).is_accepted
    flight.run(20.0, lambda: flight.client.telemetry.is_armable)
    flight.run(1.0)
    return flight


def test_telemetry_is_the_autopilots_estimate_in_the_scenes_frame(flight):
    flight = connected(flight())
    telemetry, estimate = flight.client.telemetry, flight.bench.plant.estimate
    assert telemetry.position_enu_m == pytest.approx(estimate.position_enu_m, abs=0.02)
    assert telemetry.velocity_enu_mps == pytest.approx(estimate.velocity_enu_mps, abs=1e-5)
    dot = sum(a * b for a, b in zip(telemetry.quat_wxyz, estimate.quat_wxyz, strict=True))
    assert abs(dot) == pytest.approx(1.0, abs=1e-6)
    assert telemetry.yaw_rad == pytest.approx(0.3, abs=0.1)
    assert telemetry.landed_state == LANDED_ON_GROUND
    assert telemetry.is_navigating
    assert not telemetry.is_armed


def test_setpoints_arrive_as_they_were_meant(flight):
    flight = connected(flight())
    flight.reference = FlatReference(
        position_enu_m=(1.0, -2.0, 3.0),
        velocity_enu_mps=(0.3, 0.2, 0.1),
        acceleration_enu_mps2=(0.05, -0.04, 0.03),
        yaw_rad=2.0,
        yaw_rate_radps=0.2,
    )
    flight.run(0.5)
    assert flight.do(flight.client.set_mode(PX4_OFFBOARD)).is_accepted
    assert flight.do(flight.client.arm()).is_accepted
    flight.run(3.0)
    setpoint = flight.bench.autopilot.setpoint
    reference = flight.reference
    assert setpoint.position_enu_m == pytest.approx(reference.position_enu_m, abs=0.02)
    assert setpoint.velocity_enu_mps == pytest.approx(reference.velocity_enu_mps, abs=1e-5)
    assert setpoint.acceleration_enu_mps2 == pytest.approx(
        reference.acceleration_enu_mps2, abs=1e-5
    )
    assert math.remainder(setpoint.yaw_rad - 2.0, 2 * math.pi) == pytest.approx(0, abs=1e-5)
    assert setpoint.yaw_rate_radps == pytest.approx(0.2, abs=1e-5)
    flight.run(4.0)
    assert flight.client.telemetry.landed_state == mav.MAV_LANDED_STATE_IN_AIR
    assert flight.client.telemetry.position_enu_m == pytest.approx((1.0, -2.0, 3.0), abs=0.5)
    assert flight.do(flight.client.disarm()).state is CommandState.REFUSED
    assert flight.do(flight.client.set_mode(PX4_HOLD)).is_accepted
    flight.run(0.5)
    assert flight.client.telemetry.custom_mode == PX4_HOLD


def test_commands_that_get_lost_are_repeated_until_acknowledged(flight):
    flight = flight(loses=[n for n in range(100) if n % 4])
    command = flight.do(flight.client.request_streams()[0])
    assert command.is_accepted
    assert command.tries > 1
    assert flight.client.telemetry.local_origin_enu_m == pytest.approx((0, 0, 0.11), abs=0.02)


def test_a_vehicle_that_never_answers_is_given_up(flight):
    flight = flight(loses=range(1000))
    command = flight.do(flight.client.arm())
    assert command.state is CommandState.UNANSWERED
    assert command.outcome() == "unanswered"
    assert command.tries == 5


def test_refusals_come_with_their_result(flight):
    flight = connected(flight())
    unknown = flight.do(flight.client.command(31999))
    assert unknown.state is CommandState.REFUSED
    assert unknown.outcome() == "unsupported"
    # Offboard mode wants a stream of setpoints first.
    early = flight.do(flight.client.set_mode(PX4_OFFBOARD))
    assert early.outcome() == "temporarily_rejected"
    assert flight.client.telemetry.texts


def test_two_commands_of_one_kind_get_their_own_answers(flight):
    flight = connected(flight())
    good = flight.client.command(mav.MAV_CMD_REQUEST_MESSAGE, 148.0)
    bad = flight.client.command(mav.MAV_CMD_REQUEST_MESSAGE, 16_000_000.0)
    flight.do(bad)
    assert good.is_accepted
    assert bad.state is CommandState.REFUSED


def test_heartbeats_come_once_a_second_and_nothing_else_unasked(flight):
    flight = flight()
    flight.run(10.0)
    assert flight.pipe.n_sent == 10


def test_a_text_of_several_pieces_is_read_as_one(flight):
    flight = connected(flight())
    text = "Failsafe activated: position lost, and this is longer than one message holds"
    flight.bench.autopilot._events.report(Severity.WARNING, text)
    flight.bench.run(2.0)
    assert text in [said for _, said in flight.client.telemetry.texts]
