"""An error in answering one client costs that client's message, and nothing else."""

import socket

import pytest

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.links import InProcessLink, TcpServerLink
from flightsim.mavlink.logs import FlightRecorder
from flightsim.mavlink.parameters import ParameterService
from flightsim.mavlink.server import MavlinkServer
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import Wire, named
from tests.instances import free_port

_ATTITUDE = LAYOUTS["ATTITUDE"].message_id
_PING = LAYOUTS["PING"].message_id
_SYS_STATUS = LAYOUTS["SYS_STATUS"].message_id


class _Two:
    """A server with two clients, stepped together."""

    def __init__(self, field):
        self.flight = Flight(field)
        self.flight.server.close()
        self.links = [InProcessLink(), InProcessLink()]
        plant, frame = self.flight.plant, self.flight.frame
        self.server = MavlinkServer(self.flight.autopilot, plant, frame, self.links)
        self.wires = [Wire(), Wire(system_id=254)]
        self.texts = []
        self.server.statustext.listeners.append(lambda _, text: self.texts.append(text))
        for link in self.links:
            link.client.recv()

    def send(self, index, name, *values):
        self.links[index].client.send(self.wires[index].encode(name, *values))

    def step(self):
        self.flight.plant.advance()
        self.flight.autopilot.update()
        self.server.update()
        clients = zip(self.links, self.wires, strict=True)
        return [wire.decode(link.client.recv()) for link, wire in clients]


@pytest.fixture
def two(field):
    two = _Two(field)
    yield two
    two.server.close()


def test_a_message_that_cannot_be_answered_costs_itself_alone(two):
    answer = two.server._handlers[_PING]

    def fail_at_odd(channel, message):
        if message.seq % 2:
            raise ZeroDivisionError("odd")
        answer(channel, message)

    two.server._handlers[_PING] = fail_at_odd
    for sequence in range(6):
        two.send(0, "PING", 0, sequence, 0, 0)
    two.send(1, "PING", 0, 8, 0, 0)
    first, second = two.step()
    own = [[m for m in named(came, "PING") if m.get_srcSystem() == 1] for came in (first, second)]
    assert [[ping.seq for ping in pings] for pings in own] == [[0, 2, 4], [8]]
    assert two.server.faults.n_caught == 3
    assert [text for text in two.texts if "fault" in text] == [two.texts[0]]
    assert two.texts[0].startswith("MAVLink fault, a message is lost: ZeroDivisionError in test_f")
    assert two.texts[0].endswith(": odd")


def test_due_work_that_fails_is_given_up_for_its_partner_alone(two, monkeypatch):
    two.step()
    broken, update = two.server.channels[0], ParameterService.update

    def fail(service, channel):
        if channel is broken:
            raise OverflowError("cannot be sent")
        update(service, channel)

    monkeypatch.setattr(ParameterService, "update", fail)
    for index in range(2):
        two.send(index, "PARAM_REQUEST_LIST", 1, 1)
    came = [two.step() for _ in range(100)]
    assert two.server.faults.n_caught == 1  # The list is given up.
    listed = [named([m for both in came for m in both[i]], "PARAM_VALUE") for i in range(2)]
    assert {value.param_id for value in listed[0]} == {"_HASH_CHECK"}
    assert len(listed[1]) == len(two.flight.autopilot.parameters) + 1


def test_a_message_that_cannot_be_packed_costs_itself_alone(two):
    def fail():
        raise ZeroDivisionError("cannot be packed")

    two.step()
    two.server.telemetry._producers[_SYS_STATUS] = fail
    came = [two.step() for _ in range(100)]
    assert two.server.faults.n_caught > 5
    assert len([text for text in two.texts if "fault" in text]) == 1
    for index in range(2):
        heard = [m for both in came for m in both[index]]
        assert len(named(heard, "HEARTBEAT")) == 2
        assert not named(heard, "SYS_STATUS")
        assert len(named(heard, "HIGHRES_IMU")) == 100


def test_faults_are_told_once_for_each_way_and_interrupts_pass():
    told = []
    faults = Faults(told.append)

    def divide(by):
        with faults:
            return 1 / by

    for _ in range(5):
        divide(0)
    assert faults.n_caught == 5
    with faults:
        raise ValueError("two\nlines")
    assert faults.has_failed
    assert divide(1) == 1
    assert not faults.has_failed
    assert len(told) == 2
    assert told[1].endswith(": two lines")
    with pytest.raises(KeyboardInterrupt), faults:
        raise KeyboardInterrupt


@pytest.mark.parametrize("interval_us", [1e30, 5e9])
@pytest.mark.parametrize("is_int", [False, True])
def test_an_interval_beyond_all_bounds_is_told_within_them(field, interval_us, is_int):
    flight = Flight(field)
    port = free_port(socket.SOCK_STREAM)
    server = MavlinkServer(flight.autopilot, flight.plant, flight.frame, [TcpServerLink(port=port)])
    wire, came = Wire(), []
    name, extra = ("COMMAND_INT", (0, 0)) if is_int else ("COMMAND_LONG", (0,))
    with socket.create_connection(("127.0.0.1", port)) as client:
        client.settimeout(0.05)
        for number in (mav.MAV_CMD_SET_MESSAGE_INTERVAL, mav.MAV_CMD_GET_MESSAGE_INTERVAL):
            head = (1, 1, 0, number, *extra) if is_int else (1, 1, number, *extra)
            parameters = (_ATTITUDE, interval_us, 0, 0, 0, 0, 0)
            client.sendall(wire.encode(name, *head, *parameters))
        for _ in range(40):
            flight.plant.advance()
            server.update()
            try:
                came += wire.decode(client.recv(65536))
            except TimeoutError:
                continue
            if named(came, "MESSAGE_INTERVAL"):
                break
    server.close()
    flight.server.close()
    assert [ack.result for ack in named(came, "COMMAND_ACK")] == [0, 0]
    (told,) = named(came, "MESSAGE_INTERVAL")
    assert (told.message_id, told.interval_us) == (_ATTITUDE, 2**31 - 1)
    assert server.faults.n_caught == 0


def test_what_looks_at_each_tick_may_fail_and_the_rest_goes_on(two, monkeypatch):
    two.step()

    def fail(_recorder):
        raise LookupError("nothing to see")

    monkeypatch.setattr(FlightRecorder, "update", fail)
    two.send(0, "PING", 0, 5, 0, 0)
    first, _ = two.step()
    assert [ping.seq for ping in named(first, "PING") if ping.get_srcSystem() == 1] == [5]
    two.step()
    assert two.server.faults.n_caught == 2
    assert [text for text in two.texts if "nothing to see" in text] == [two.texts[0]]
    assert "LookupError in test_faults.py" in two.texts[0]
