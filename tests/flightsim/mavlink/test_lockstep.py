"""Simulated time waits for the client that grants it."""

import pytest

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.links import InProcessLink
from flightsim.mavlink.server import MavlinkServer
from flightsim.simulator import Simulator
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import Wire, named


class Lockstep:
    """A vehicle whose time two clients may ask for."""

    def __init__(self, world):
        self.flight = Flight(world)
        self.flight.server.close()
        self.plant = self.flight.plant
        self.links = [InProcessLink(name="first"), InProcessLink(name="second")]
        self.server = MavlinkServer(
            self.flight.autopilot, self.plant, self.flight.frame, self.links, has_lockstep=True
        )
        self.wires = [Wire(), Wire()]
        self.simulator = Simulator(self.plant, self.flight.autopilot, self.server, speed="max")

    def send(self, client, name, *values):
        self.links[client].client.send(self.wires[client].encode(name, *values))

    def grant(self, client, ticks):
        self.send(client, "COMMAND_LONG", 1, 1, mav.MAV_CMD_USER_1, 0, ticks, *[0.0] * 6)

    def run(self, rounds=20):
        """Let the loop look for ticks that many times."""
        left = [rounds]

        def is_done():
            left[0] -= 1
            return left[0] < 0

        self.simulator.run(stop=is_done)

    def heard(self, client):
        return self.wires[client].decode(self.links[client].client.recv())


@pytest.fixture
def lockstep(field, monkeypatch):
    monkeypatch.setattr("flightsim.simulator._LOCKSTEP_WAIT_S", 0.0)
    lockstep = Lockstep(field)
    yield lockstep
    lockstep.server.close()


def test_time_stands_until_ticks_are_granted_and_then_passes_as_far(lockstep):
    lockstep.send(0, "HEARTBEAT", 6, 8, 0, 0, 4, 3)
    lockstep.run()
    assert lockstep.plant.time_us == 0
    lockstep.grant(0, 3)
    lockstep.run()
    assert lockstep.plant.time_us == 60_000


def test_the_acknowledgement_is_the_last_of_what_the_ticks_send(lockstep):
    lockstep.grant(0, 60)
    lockstep.run(30)
    assert not named(lockstep.heard(0), "COMMAND_ACK")
    lockstep.run(40)
    heard = lockstep.heard(0)
    assert heard[-1].get_type() == "COMMAND_ACK"
    assert (heard[-1].command, heard[-1].result) == (mav.MAV_CMD_USER_1, 0)
    assert len(heard) > 10


def test_a_command_is_answered_while_time_stands(lockstep):
    lockstep.grant(0, 100)
    lockstep.run(110)
    lockstep.heard(0)
    now_us = lockstep.plant.time_us
    lockstep.send(0, "COMMAND_LONG", 1, 1, mav.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, *[0.0] * 6)
    lockstep.run()
    assert named(lockstep.heard(0), "COMMAND_ACK")[-1].result == 0
    assert lockstep.flight.autopilot.is_armed
    assert lockstep.plant.time_us == now_us


def test_what_is_sent_behind_a_grant_waits_for_its_end(lockstep):
    lockstep.grant(0, 100)
    lockstep.send(0, "COMMAND_LONG", 1, 1, mav.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, *[0.0] * 6)
    lockstep.run(50)
    assert not lockstep.flight.autopilot.is_armed
    lockstep.run(70)
    assert lockstep.flight.autopilot.is_armed  # at 2 s, and not refused at once at 0 s


def test_the_first_who_grants_keeps_the_time(lockstep):
    lockstep.grant(0, 2)
    lockstep.run()
    lockstep.grant(1, 2)
    lockstep.run()
    assert lockstep.plant.time_us == 40_000
    (ack,) = named(lockstep.heard(1), "COMMAND_ACK")
    assert ack.result == mav.MAV_RESULT_TEMPORARILY_REJECTED


@pytest.mark.parametrize("ticks", [0, -1, 1.5, 50_001, float("nan"), 1e30])
def test_a_number_of_ticks_that_is_none_is_denied(lockstep, ticks):
    lockstep.grant(0, ticks)
    lockstep.run()
    (ack,) = named(lockstep.heard(0), "COMMAND_ACK")
    assert ack.result == mav.MAV_RESULT_DENIED
    assert lockstep.plant.time_us == 0


def test_without_lockstep_nobody_can_stop_the_time(flight):
    assert flight.command(mav.MAV_CMD_USER_1, 1) == mav.MAV_RESULT_UNSUPPORTED
    assert flight.server.wait_for_tick(0.0)
