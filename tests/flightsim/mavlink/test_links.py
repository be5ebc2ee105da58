"""Links on real ports: partners come, several at once, and go without a trace."""

import selectors
import socket
import time

import pytest

from flightsim.mavlink.dialect import layout
from flightsim.mavlink.links import (
    InProcessLink,
    LinkError,
    OutAddress,
    PortInUseError,
    TcpServerLink,
    UdpLink,
    UdpOutLink,
)
from tests.flightsim.mavlink.wire import Wire, named
from tests.instances import free_port

_PING = layout("PING")


class _Host:
    """Opens a link and polls it as the server does."""

    def __init__(self, link):
        self.link = link
        self.selector = selectors.DefaultSelector()
        link.open(self.selector, lambda: 0)

    def poll(self):
        for key, _ in self.selector.select(0):
            key.data()
        return {channel: channel.take_messages() for channel in self.link.channels}

    def poll_until(self, is_done):
        deadline = time.monotonic() + 10.0
        while time.monotonic() < deadline:
            received = self.poll()
            if is_done(received):
                return received
        raise AssertionError("nothing came within 10 s")

    def say_to_all(self, sequence=0):
        for channel in self.link.channels:
            channel.send(_PING, _PING.encode(seq=sequence, target_system=9))
            channel.flush()

    def close(self):
        self.link.close()
        self.selector.close()


@pytest.fixture
def udp():
    local, remote = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_DGRAM)
    host = _Host(UdpLink(local_port=local, remote_port=remote))
    host.local, host.remote = ("127.0.0.1", local), ("127.0.0.1", remote)
    yield host
    host.close()


@pytest.fixture
def tcp():
    port = free_port(socket.SOCK_STREAM)
    host = _Host(TcpServerLink(port=port))
    host.address = ("127.0.0.1", port)
    yield host
    host.close()


def _udp_client(port=0):
    client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    client.bind(("127.0.0.1", port))
    client.settimeout(10.0)
    return client


def _any(received):
    return any(received.values())


def test_udp_speaks_first_and_hears_the_reply_on_the_same_channel(udp):
    wire = Wire()
    with _udp_client(udp.remote[1]) as client:
        udp.say_to_all(sequence=5)
        data, vehicle = client.recvfrom(2048)
        assert vehicle == udp.local
        assert [message.seq for message in wire.decode(data)] == [5]
        client.sendto(wire.encode("PING", 0, 6, 0, 0), vehicle)
        received = udp.poll_until(_any)
    assert [[message.seq for message in messages] for messages in received.values()] == [[6]]


def test_udp_answers_unknown_partners_besides_the_default_one(udp):
    with _udp_client() as first, _udp_client() as second, _udp_client(udp.remote[1]) as default:
        for index, client in enumerate((first, second)):
            client.sendto(Wire().encode("PING", 0, index, 0, 0), udp.local)
        udp.poll_until(lambda _: len(udp.link.channels) == 3)
        udp.say_to_all(sequence=7)
        for client in (first, second, default):
            (message,) = Wire().decode(client.recv(2048))
            assert (message.seq, message.get_seq()) == (7, 0)


def test_udp_keeps_eight_partners_and_takes_no_more_while_they_talk(udp):
    clients = [_udp_client() for _ in range(12)]
    for client in clients:
        client.sendto(Wire().encode("PING", 0, 0, 0, 0), udp.local)
    for _ in range(20):
        udp.poll()
    assert len(udp.link.channels) == 8
    for client in clients:
        client.close()


@pytest.mark.parametrize(
    "data", [b"x", b"\xfd", b"\xfd\x05" + bytes(40), b"\xfe" * 60, bytes(1400)]
)
def test_udp_senders_of_anything_but_mavlink_take_no_place(udp, data):
    strangers = [_udp_client() for _ in range(12)]
    for stranger in strangers:
        stranger.sendto(data, udp.local)
    udp.poll()
    with _udp_client() as client:
        client.sendto(Wire().encode("PING", 0, 3, 0, 0), udp.local)
        udp.poll_until(_any)
    assert len(udp.link.channels) == 2
    for stranger in strangers:
        stranger.close()


def test_udp_partners_that_vanish_disturb_nothing(udp):
    client = _udp_client()
    client.sendto(Wire().encode("PING", 0, 0, 0, 0), udp.local)
    udp.poll_until(lambda _: len(udp.link.channels) == 2)
    client.close()
    for sequence in range(100):
        udp.say_to_all(sequence)
        udp.poll()
    with _udp_client() as another:
        another.sendto(Wire().encode("PING", 0, 3, 0, 0), udp.local)
        assert udp.poll_until(_any)


def test_a_tick_is_joined_into_few_datagrams_and_no_frame_is_divided(udp):
    with _udp_client(udp.remote[1]) as client:
        (channel,) = udp.link.channels
        channel.lengthen_datagrams()
        for sequence in range(200):
            channel.send(_PING, _PING.encode(seq=sequence, time_usec=2**60))
        channel.flush()
        wire, sequences, n_datagrams = Wire(), [], 0
        while len(sequences) < 200:
            data = client.recv(65536)
            assert len(data) <= 2000
            n_datagrams += 1
            sequences += [message.seq for message in wire.decode(data)]
    assert sequences == list(range(200))
    assert n_datagrams == 3  # 83 frames of 24 bytes fit into one


def test_tcp_serves_several_clients_each_with_its_own_numbers(tcp):
    with socket.create_connection(tcp.address) as a, socket.create_connection(tcp.address) as b:
        tcp.poll_until(lambda _: len(tcp.link.channels) == 2)
        a.sendall(Wire().encode("PING", 0, 1, 0, 0))
        b.sendall(Wire().encode("PING", 0, 2, 0, 0))
        heard = []
        tcp.poll_until(
            lambda received: (
                heard.extend(m.seq for ms in received.values() for m in ms) or len(heard) == 2
            )
        )
        assert sorted(heard) == [1, 2]
        tcp.say_to_all()
        assert [m.get_seq() for c in (a, b) for m in Wire().decode(c.recv(2048))] == [0, 0]


def test_tcp_frames_arrive_though_they_come_in_crumbs(tcp):
    frames = b"".join(Wire().encode("PING", 0, index, 0, 0) for index in range(5))
    heard = []
    with socket.create_connection(tcp.address) as client:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for start in range(0, len(frames), 7):
            client.sendall(frames[start : start + 7])
            received = tcp.poll()
            heard += [m.seq for messages in received.values() for m in messages]
        tcp.poll_until(
            lambda received: (
                heard.extend(m.seq for ms in received.values() for m in ms) or len(heard) == 5
            )
        )
    assert heard == list(range(5))


def test_a_tcp_client_that_vanishes_is_cleared_away(tcp):
    client = socket.create_connection(tcp.address)
    tcp.poll_until(lambda _: len(tcp.link.channels) == 1)
    (channel,) = tcp.link.channels
    # A reset instead of a farewell: what is left unread is thrown away.
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\0\0\0\0\0\0\0")
    client.close()
    for _ in range(50):
        tcp.say_to_all()
        tcp.poll()
    assert tcp.link.channels == ()
    assert not channel.is_open


def test_a_tcp_client_that_does_not_read_blocks_nobody(tcp):
    with socket.create_connection(tcp.address) as deaf, socket.create_connection(tcp.address) as b:
        tcp.poll_until(lambda _: len(tcp.link.channels) == 2)
        deaf_channel = tcp.link.channels[0]
        for _ in range(400):
            for _ in range(600):
                deaf_channel.send(_PING, _PING.encode(time_usec=2**60))
            deaf_channel.flush()
        tcp.say_to_all(sequence=9)
        assert [m.seq for m in Wire().decode(b.recv(2048))] == [9]
        assert len(tcp.link.channels) == 2
        deaf.close()


def test_tcp_clients_that_come_together_are_welcome_together(tcp):
    clients = [socket.create_connection(tcp.address) for _ in range(8)]
    tcp.poll()
    assert len(tcp.link.channels) == 8
    for client in clients:
        client.close()


def test_a_ninth_tcp_client_is_turned_away_which_is_told_once(tcp, caplog):
    clients = [socket.create_connection(tcp.address) for _ in range(11)]
    for _ in range(30):
        tcp.poll()
    assert len(tcp.link.channels) == 8
    assert len(caplog.messages) == 1
    assert caplog.messages[0].startswith(f"{tcp.link.name} 127.0.0.1:")
    assert caplog.messages[0].endswith(" is turned away: 8 clients are connected")
    for client in clients:
        client.close()


def test_a_port_in_use_is_named_with_the_way_out(udp, tcp):
    with pytest.raises(PortInUseError, match=rf"UDP port {udp.local[1]} .*another --instance"):
        _Host(UdpLink(local_port=udp.local[1], remote_port=1))
    with pytest.raises(PortInUseError, match=rf"TCP port {tcp.address[1]} .*another --instance"):
        _Host(TcpServerLink(port=tcp.address[1]))


def test_an_address_of_another_machine_is_named():
    with pytest.raises(LinkError, match=r"203\.0\.113\.7"):
        _Host(TcpServerLink(port=free_port(socket.SOCK_STREAM), bind_address="203.0.113.7"))


def test_links_listen_on_loopback_only(udp, tcp):
    names = [
        key.fileobj.getsockname()[0]
        for host in (udp, tcp)
        for key in host.selector.get_map().values()
    ]
    assert names == ["127.0.0.1"] * 2


def test_ports_are_free_again_after_closing():
    port = free_port(socket.SOCK_STREAM)
    for _ in range(2):
        host = _Host(TcpServerLink(port=port))
        client = socket.create_connection(("127.0.0.1", port))
        host.poll_until(lambda _, host=host: len(host.link.channels) == 1)
        host.close()
        host.link.close()
        client.close()


def test_the_in_process_client_meets_the_same_channel_in_simulated_time():
    link, wire = InProcessLink(), Wire()
    host = _Host(link)
    assert host.poll() == {}
    link.client.send(wire.encode("PING", 0, 4, 0, 0))
    ((channel, messages),) = host.poll().items()
    assert [message.seq for message in messages] == [4]
    assert channel.clock() == 0.0
    host.say_to_all(sequence=8)
    assert [message.seq for message in named(wire.decode(link.client.recv()), "PING")] == [8]
    assert link.client.recv() == b""
    host.close()


def _ping(sequence):
    return Wire().encode("PING", 0, sequence, 0, 0)


@pytest.fixture
def listener():
    client = _udp_client()
    yield client
    client.close()


def test_the_vehicle_speaks_first_to_an_address_that_is_named(listener):
    port = listener.getsockname()[1]
    host = _Host(UdpOutLink(OutAddress.parse(f"udp:localhost:{port}")))
    try:
        host.say_to_all()
        data, vehicle = listener.recvfrom(2048)
        assert data
        listener.sendto(_ping(7), vehicle)
        (channel,) = host.link.channels
        received = host.poll_until(_any)
        assert [message.seq for message in received[channel]] == [7]
    finally:
        host.close()


def test_nobody_but_the_named_address_is_heard(listener):
    """Its port may be open to a network, unlike those on loopback."""
    port = listener.getsockname()[1]
    host = _Host(UdpOutLink(OutAddress.parse(f"udp:127.0.0.1:{port}")))
    stranger = _udp_client()
    try:
        host.say_to_all()
        _, vehicle = listener.recvfrom(2048)
        stranger.sendto(_ping(1), vehicle)
        listener.sendto(_ping(2), vehicle)
        (messages,) = host.poll_until(_any).values()
        assert [message.seq for message in messages] == [2]
    finally:
        stranger.close()
        host.close()


def test_it_goes_on_where_nobody_listens_yet():
    port = free_port(socket.SOCK_DGRAM)
    host = _Host(UdpOutLink(OutAddress.parse(f"udp:127.0.0.1:{port}")))
    try:
        for _ in range(3):
            host.say_to_all()
            host.poll()
        late = _udp_client(port)
        host.say_to_all()
        host.say_to_all()
        assert late.recv(2048)
        late.close()
    finally:
        host.close()


@pytest.mark.parametrize(
    "text",
    ["", "udp", "udp:host", "udp::14550", "udp:127.0.0.1:", "udp:127.0.0.1:0", "udp:a:70000"]
    + ["tcp:127.0.0.1:5760", "127.0.0.1:14550", "udp:127.0.0.1:٤٢", "udp:no.such.host.invalid:1"],
)
def test_what_is_no_address_to_speak_to_is_refused(text):
    with pytest.raises(LinkError, match="valid: udp:HOST:PORT"):
        OutAddress.parse(text)
