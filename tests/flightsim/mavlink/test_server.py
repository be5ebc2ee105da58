"""The server as a whole: nothing that a client sends ends the flight or slows it without bound."""

import math
import random
import socket
import struct
import time

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import LAYOUTS, dialect
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.files import FileService
from flightsim.mavlink.links import InProcessLink, PortInUseError, TcpServerLink, UdpLink
from flightsim.mavlink.logs import LogService
from flightsim.mavlink.mission import MissionService
from flightsim.mavlink.parameters import ParameterService
from flightsim.mavlink.server import MavlinkServer
from flightsim.mavlink.shell import ShellService
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import Wire, named
from tests.instances import free_port

# Commands that end a flight when they are meant: not what a fuzz test is after.
_ENDING = {400, 185, 20, 21, 176, 262, 92, 22}


def _random_frame(rng: random.Random, message_class) -> bytes:
    """A valid frame of random payload, or of one with telling values."""
    layout = LAYOUTS[message_class.msgname]
    size = message_class.unpacker.size
    payload = bytearray(rng.randbytes(size))
    if rng.random() < 0.5:
        for offset in range(0, size - 3, 4):
            value = rng.choice([0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e30, 3.5, 300.0])
            payload[offset : offset + 4] = struct.pack("<f", value)
    if rng.random() < 0.7:  # meant for this vehicle
        payload = _addressed(message_class, payload)
    build = layout.frame_v1 if rng.random() < 0.2 else layout.frame_v2
    return build(bytes(payload), rng.randrange(256), 255, 190)


def _addressed(message_class, payload):
    values = list(message_class.unpacker.unpack(bytes(payload)))
    position = 0
    for field, length in zip(message_class.ordered_fieldnames, message_class.lengths, strict=True):
        if field in {"target_system", "target_component"}:
            values[position] = 1
        position += 1 if isinstance(values[position], bytes) else length
    return bytearray(message_class.unpacker.pack(*values))


@pytest.mark.parametrize("seed", range(3))
def test_random_valid_frames_end_nothing(flight, seed):
    rng = random.Random(seed)
    flight.take_off(20.0)
    handled = [c for c in dialect.mavlink_map.values() if c.id in flight.server._handlers]
    assert len(handled) > 25
    everything = list(dialect.mavlink_map.values())
    n_ticks = 400
    for _ in range(n_ticks):
        for _ in range(15):
            message_class = rng.choice(handled if rng.random() < 0.8 else everything)
            frame = _random_frame(rng, message_class)
            if message_class.msgname in {"COMMAND_LONG", "COMMAND_INT", "SET_MODE"}:
                decoded = dialect.MAVLink(None).decode(bytearray(frame))
                if getattr(decoded, "command", 176) in _ENDING:
                    continue
            flight.link.client.send(frame)
        flight.step()
    came = flight.run(2.0)
    assert named(came, "HEARTBEAT")
    assert flight.autopilot.is_armed
    assert all(map(math.isfinite, flight.plant.truth.position_enu_m))


def test_every_command_is_answered_once_whatever_its_parameters(flight):
    rng = random.Random(1)
    flight.become_ready()
    values = [0.0, 1.0, 2.0, -1.0, math.nan, math.inf, -math.inf, 1e38, 47.4, 2**31, 65536.5]
    for number in sorted({*range(300), *mav.enums["MAV_CMD"], 65535}):
        for is_int in (False, True):
            params = [rng.choice(values) for _ in range(7)]
            if is_int:
                params[4:6] = [rng.choice([0, -(2**31), 2**31 - 1, 474000000]) for _ in range(2)]
                frame = rng.choice([0, 1, 3, 5, 6, 10, 11, 12, 255])
                flight.send("COMMAND_INT", 1, 1, frame, number, 0, 0, *params)
            else:
                flight.send("COMMAND_LONG", 1, 1, number, 0, *params)
            acks = [m for m in named(flight.step(), "COMMAND_ACK") if m.command == number]
            assert len(acks) == 1
    assert named(flight.run(2.0), "HEARTBEAT")


@pytest.mark.parametrize("seed", range(2))
def test_random_bytes_end_nothing(flight, seed):
    rng = random.Random(seed)
    flight.take_off(5.0)
    for _ in range(300):
        data = rng.randbytes(rng.randrange(200))
        flight.link.client.send(data if rng.random() < 0.5 else b"\xfd" + data)
        flight.step()
    assert flight.autopilot.is_armed
    # Whatever half frame is left swallows at most one valid frame.
    for _ in range(20):
        flight.send("PING", 0, 5, 0, 0)
    assert named(flight.run(1.0), "PING")


def test_the_vehicle_hears_companions_with_its_own_system_id_but_not_itself(flight):
    flight.become_ready()
    companion, itself = Wire(system_id=1, component_id=191), Wire(system_id=1, component_id=1)
    flight.link.client.send(itself.encode("PING", 0, 1, 0, 0))
    flight.link.client.send(companion.encode("PING", 0, 2, 0, 0))
    pings = named(flight.step(), "PING")
    assert [(ping.seq, ping.target_component) for ping in pings] == [(2, 191)]


def test_clocks_are_compared_in_simulated_time(flight):
    flight.run(3.0)
    flight.send("TIMESYNC", 0, 123)
    flight.send("TIMESYNC", 7, 123)
    (answer,) = named(flight.step(), "TIMESYNC")
    assert (answer.tc1, answer.ts1) == (flight.plant.time_us * 1000, 123)


def test_the_origin_stays_and_is_told(flight):
    flight.send("SET_GPS_GLOBAL_ORIGIN", 1, 473977420, 85455940, 0)
    came = flight.step()
    (origin,) = named(came, "GPS_GLOBAL_ORIGIN")
    place = flight.frame.geodetic_from_enu((12.0, -7.0, 0.0))
    assert origin.latitude == pytest.approx(place.latitude_deg * 1e7, abs=1)
    assert named(came, "STATUSTEXT")[0].text == "The origin stays where the vehicle started"


@pytest.mark.parametrize(
    ("name", "values"), [("PLAY_TUNE", (1, 1, b"MLT")), ("PLAY_TUNE_V2", (1, 1, 1, b"MLT"))]
)
def test_a_tune_is_not_played_and_that_is_said(flight, name, values):
    (message_class,) = [c for c in dialect.mavlink_map.values() if c.msgname == name]
    frame = message_class(*values).pack(dialect.MAVLink(None, 255, 190))
    flight.link.client.send(bytes(frame))
    said = "".join(text.text for text in named(flight.step(), "STATUSTEXT"))
    assert said == f"{name} is ignored: there is no buzzer"


def test_a_service_is_called_only_for_partners_with_work_due(flight, monkeypatch):
    called = []
    for service in (ParameterService, MissionService, ShellService, LogService, FileService):

        def update(self, channel, real=service.update):
            called.append(type(self))
            real(self, channel)

        monkeypatch.setattr(service, "update", update)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.run(1.0)
    assert called == []
    flight.send("PARAM_REQUEST_LIST", 1, 1)
    flight.send("MISSION_COUNT", 1, 1, 1, 0)
    came = flight.run(6.0)  # until the upload has timed out
    assert len(named(came, "PARAM_VALUE")) == 1 + len(flight.autopilot.parameters)
    assert set(called) == {ParameterService, MissionService}
    called.clear()
    flight.run(1.0)
    assert called == []


def test_a_ground_station_that_falls_silent_is_noticed(flight):
    flight.take_off(8.0)
    flight.autopilot.parameters.set("NAV_DLL_ACT", 2)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.run(8.0)
    assert flight.autopilot.mode is Mode.HOLD
    flight.run(5.0)
    assert flight.autopilot.mode is Mode.RETURN


def test_a_ground_station_in_wall_time_is_not_lost_in_fast_simulated_time(flight, monkeypatch):
    flight.take_off(8.0)
    flight.autopilot.parameters.set("NAV_DLL_ACT", 2)
    (channel,) = flight.server.channels
    monkeypatch.setattr(channel, "clock", lambda: flight.plant.time_us * 1e-6 / 30.0)
    for _ in range(3):  # a heartbeat in 30 simulated seconds
        flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        flight.skip(30.0)
    assert flight.autopilot.mode is Mode.HOLD
    flight.skip(40.0)
    assert flight.autopilot.mode is not Mode.HOLD


def test_the_budget_of_one_partner_bounds_the_work_of_a_tick(flight):
    flight.run(1.0)
    flood = b"".join(flight.wire.encode("PING", 0, index, 0, 0) for index in range(3000))
    flight.link.client.send(flood)
    answered = [len(named(flight.step(), "PING")) for _ in range(20)]
    assert max(answered) <= 200
    assert answered[-1] <= 20


def test_socket_clients_come_and_vanish_in_flight(flight):
    udp_local, udp_remote = (free_port(socket.SOCK_DGRAM) for _ in range(2))
    tcp_port = free_port(socket.SOCK_STREAM)
    links = [
        UdpLink(local_port=udp_local, remote_port=udp_remote, profile="onboard"),
        TcpServerLink(port=tcp_port),
    ]
    server = MavlinkServer(flight.autopilot, flight.plant, flight.frame, links, system_id=9)

    def tick(count=1):
        for _ in range(count):
            flight.plant.advance()
            flight.autopilot.update()
            server.update()

    tick(100)
    for _ in range(3):
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.bind(("127.0.0.1", udp_remote))
        tcp = socket.create_connection(("127.0.0.1", tcp_port))
        udp.settimeout(5.0)
        tcp.settimeout(5.0)
        tick(60)
        assert named(_heard(udp), "HEARTBEAT")[0].get_srcSystem() == 9
        assert named(_heard(tcp), "HEARTBEAT")
        udp.close()
        tcp.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        tcp.close()
        tick(60)
    assert len(server.channels) == 1
    server.close()
    server.close()


def _heard(client: socket.socket):
    wire, came = Wire(), []
    deadline = time.monotonic() + 5.0
    while time.monotonic() < deadline and not named(came, "HEARTBEAT"):
        came += wire.decode(client.recv(65536))
    return came


def test_links_opened_before_the_one_that_fails_are_closed_again(flight):
    port = free_port(socket.SOCK_STREAM)
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        taken = TcpServerLink(port=holder.getsockname()[1])
        links = [InProcessLink(), TcpServerLink(port=port), taken]
        with pytest.raises(PortInUseError):
            MavlinkServer(flight.autopilot, flight.plant, flight.frame, links)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", port))


def test_two_runs_with_the_same_client_send_the_same_bytes(field):
    def run():
        flight = Flight(field)
        flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        data = bytearray()
        for step in range(400):
            if step == 350:
                flight.send(
                    "COMMAND_LONG", 1, 1, mav.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, 0, 0, 0, 0, 0, 0
                )
            flight.simulator.step()
            data += flight.link.client.recv()
        flight.server.close()
        return bytes(data)

    assert run() == run()
