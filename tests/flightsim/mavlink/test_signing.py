"""Signed links: pymavlink's signatures are believed and ours by it, and nothing else is."""

import contextlib
import socket

import pytest

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.links import TcpServerLink, UdpLink
from flightsim.mavlink.server import MavlinkServer
from flightsim.mavlink.signing import Signing, SigningKeyError, key_of_passphrase, read_key
from tests.flightsim.mavlink.wire import Wire, named
from tests.instances import free_port

KEY, OTHER_KEY = key_of_passphrase("open sesame"), key_of_passphrase("guess")
NOW_S = 1_700_000_000.0


class SignedFlight:
    """A vehicle on a TCP port, and clients that are stepped with it."""

    def __init__(self, flight, key=None):
        self.flight = flight
        self.signing = Signing(key)
        self.port = free_port(socket.SOCK_STREAM)
        links = [TcpServerLink(port=self.port, signing=self.signing)]
        self.server = MavlinkServer(
            flight.autopilot, flight.plant, flight.frame, links, signing=self.signing
        )
        self._stack = contextlib.ExitStack()
        self._stack.callback(self.server.close)

    def connect(self):
        client = self._stack.enter_context(socket.create_connection(("127.0.0.1", self.port)))
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.setblocking(False)
        return client

    def ask(self, client, wire, frame):
        """Send a frame, and return what the vehicle says to it."""
        client.sendall(frame)
        return self.hear(client, wire)

    def hear(self, client, wire, n_ticks=3):
        data = b""
        for _ in range(n_ticks):
            self.flight.plant.advance()
            self.server.update()
            with contextlib.suppress(BlockingIOError):
                data += client.recv(1 << 16)
        return wire.decode(data)

    def close(self):
        self._stack.close()


@pytest.fixture
def signed(flight):
    signed = SignedFlight(flight, KEY)
    yield signed
    signed.close()


@pytest.fixture
def unsigned(flight):
    unsigned = SignedFlight(flight)
    yield unsigned
    unsigned.close()


def _ping(wire, sequence):
    return wire.encode("PING", 0, sequence, 0, 0)


def _pings(messages):
    """What the vehicle answers, and not what it passes on."""
    return [message.seq for message in named(messages, "PING") if message.get_srcSystem() == 1]


def _signed_wire(key=KEY, seconds=None):
    wire = Wire()
    wire.sign(key, seconds)
    return wire


def test_a_client_with_the_key_is_answered_and_believes_the_answers(signed):
    client, wire = signed.connect(), _signed_wire()
    came = signed.ask(client, wire, _ping(wire, 1)) + signed.hear(client, wire, 60)
    assert _pings(came) == [1]
    assert named(came, "HEARTBEAT")
    assert all(message.get_signed() for message in came)
    assert not named(came, "BAD_DATA")


def test_what_is_not_signed_forged_replayed_or_old_is_refused(signed, caplog):
    client, wire = signed.connect(), _signed_wire()
    frame = _ping(wire, 1)
    assert _pings(signed.ask(client, wire, frame)) == [1]
    plain, forger, late = Wire(), _signed_wire(OTHER_KEY), Wire(system_id=7)
    late.sign(KEY, 1_500_000_000.0)
    damaged = bytearray(_ping(wire, 3))
    damaged[-1] ^= 1
    refused = [
        _ping(plain, 2),
        Wire(is_version_1=True).encode("PING", 0, 2, 0, 0),
        _ping(forger, 2),
        bytes(damaged),
        frame,
        _ping(late, 2),
    ]
    for bad in refused:
        assert _pings(signed.ask(client, wire, bad)) == []
    assert signed.signing.n_refused == len(refused)
    assert _pings(signed.ask(client, wire, _ping(wire, 4))) == [4]
    assert len(caplog.messages) == 4  # Each reason is told once.


def test_a_frame_recorded_on_one_link_is_not_taken_on_another(signed):
    first, second, wire = signed.connect(), signed.connect(), _signed_wire()
    frame = _ping(wire, 1)
    assert _pings(signed.ask(first, wire, frame)) == [1]
    assert _pings(signed.ask(second, Wire(), frame)) == []


def test_who_does_not_sign_is_no_ground_station_and_takes_no_place(flight):
    signing = Signing(KEY)
    link = UdpLink(local_port=0, remote_port=free_port(socket.SOCK_DGRAM), signing=signing)
    server = MavlinkServer(flight.autopilot, flight.plant, flight.frame, [link], signing=signing)
    port = link._socket.getsockname()[1]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        for wire, n_channels in ((Wire(), 1), (_signed_wire(), 2)):
            client.sendto(wire.encode("HEARTBEAT", 6, 8, 0, 0, 4, 3), ("127.0.0.1", port))
            server.update()
            assert len(server.channels) == n_channels
    assert [channel.is_heard for channel in server.channels] == [False, True]
    server.close()


def _setup(wire, key, timestamp=0):
    return wire.encode("SETUP_SIGNING", 1, 1, list(key), timestamp)


def test_a_client_sets_the_key_changes_it_and_takes_it_away(unsigned):
    client, wire = unsigned.connect(), Wire()
    assert _pings(unsigned.ask(client, wire, _ping(wire, 1))) == [1]
    came = unsigned.ask(client, wire, _setup(wire, KEY))
    assert [text.text for text in named(came, "STATUSTEXT")] == ["Signing is on"]
    assert _pings(unsigned.ask(client, wire, _ping(wire, 2))) == []
    unsigned.ask(client, wire, _setup(wire, OTHER_KEY))  # Without a signature now.
    assert unsigned.signing.key == KEY
    wire.sign(KEY)
    assert _pings(unsigned.ask(client, wire, _ping(wire, 3))) == [3]
    unsigned.ask(client, wire, _setup(wire, OTHER_KEY, 2**64 - 1))
    wire.sign(OTHER_KEY)
    assert _pings(unsigned.ask(client, wire, _ping(wire, 4))) == [4]
    unsigned.ask(client, wire, _setup(wire, bytes(32)))
    wire.sign(None)
    assert _pings(unsigned.ask(client, wire, _ping(wire, 5))) == [5]
    assert unsigned.server.faults.n_caught == 0


def test_a_key_is_refused_in_flight_and_from_a_network(unsigned):
    client, wire = unsigned.connect(), Wire()
    unsigned.ask(client, wire, _ping(wire, 1))

    def refusal(frame):
        texts = named(unsigned.ask(client, Wire(), frame), "STATUSTEXT")
        assert unsigned.signing.key is None
        return "".join(text.text for text in texts)

    (channel,) = unsigned.server.channels
    channel.is_local = False
    assert "network" in refusal(_setup(wire, KEY))
    channel.is_local = True
    unsigned.flight.become_ready()
    assert unsigned.flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    assert "armed" in refusal(_setup(wire, KEY))


def test_reports_of_radios_need_no_signature():
    signing = Signing(KEY, lambda: NOW_S)
    channel = Channel(
        "test",
        lambda _: None,
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=True,
        signing=signing,
    )
    channel.receive(Wire(is_version_1=True).encode("RADIO_STATUS", 0, 0, 0, 0, 0, 0, 0))
    assert channel.is_heard
    assert signing.n_refused == 0


def test_nobody_is_locked_out_by_frames_of_the_future():
    signing = Signing(KEY, lambda: NOW_S)
    honest, forger, broken = (Wire() for _ in range(3))
    honest.sign(KEY, NOW_S)
    forger.sign(OTHER_KEY, NOW_S + 1e6)
    broken.sign(KEY, NOW_S + 1e9)
    for wire in (forger, broken):
        assert not signing.admits(_ping(wire, 0))
    assert signing.admits(_ping(honest, 0))


def test_a_clock_that_is_behind_is_believed_for_a_minute_and_streams_are_counted():
    for behind_s, is_admitted in ((59.0, True), (61.0, False)):
        wire = Wire()
        wire.sign(KEY, NOW_S - behind_s)
        assert Signing(KEY, lambda: NOW_S).admits(_ping(wire, 0)) is is_admitted
    signing = Signing(KEY, lambda: NOW_S)
    admitted = []
    for link_id in range(100):
        wire = Wire()
        wire.sign(KEY, NOW_S, link_id=link_id)
        admitted.append(signing.admits(_ping(wire, 0)))
    assert sum(admitted) == 64


def test_timestamps_rise_though_the_clock_stands():
    signing, wire = Signing(KEY, lambda: NOW_S), Wire()
    wire.sign(KEY, NOW_S)
    plain = Wire(system_id=1)
    channel_frames = []
    channel = Channel(
        "test",
        channel_frames.extend,
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=False,
        signing=signing,
        link_id=3,
    )
    for sequence in range(5):
        channel.forward(plain.decode(_ping(plain, sequence))[0])
    channel.flush()
    came = wire.decode(b"".join(channel_frames))
    assert _pings(came) == list(range(5))
    assert {message.get_link_id() for message in came} == {3}


@pytest.mark.parametrize(
    ("data", "complaint"),
    [(b"", "no passphrase"), (b"a\nb\n", "one line"), (b"\xff\xfe", "text"), (b"x" * 2000, "1024")],
)
def test_a_file_without_a_passphrase_is_named(tmp_path, data, complaint):
    path = tmp_path / "key"
    path.write_bytes(data)
    with pytest.raises(SigningKeyError, match=complaint):
        read_key(path)
    with pytest.raises(SigningKeyError, match="No such file"):
        read_key(tmp_path / "none")


def test_a_key_is_the_hash_of_the_passphrase(tmp_path):
    path = tmp_path / "key"
    path.write_text("open sesame\n")
    assert read_key(path) == KEY
    assert KEY.hex().startswith("41ef4bb0b23661e66301aac36066912d")
