"""A serial line: pymavlink at the other end of two pseudo terminals, its pace and its loss."""

import contextlib
import os
import tty

import pytest
from pymavlink import mavutil

from flightsim.mavlink.links import InProcessLink, LinkError, SerialLine, SerialLink
from flightsim.mavlink.server import MavlinkServer
from tests.flightsim.mavlink.wire import Wire, named

TICK_S = 0.02


class Cable:
    """Two pseudo terminals whose far ends are joined, as a null modem joins two ports."""

    def __init__(self):
        self.ends, self.paths = [], []
        for _ in range(2):
            end, port = os.openpty()
            tty.setraw(port)
            os.set_blocking(end, False)
            self.ends.append(end)
            self.paths.append(os.ttyname(port))
            os.close(port)
        self.n_carried = 0

    def carry(self):
        """Take along what both ends have sent since the last time; bytes from the first end."""
        data = _read(self.ends[0])
        self.n_carried += len(data)
        for end, out in ((self.ends[1], data), (self.ends[0], _read(self.ends[1]))):
            if out:
                with contextlib.suppress(BlockingIOError):
                    os.write(end, out)  # Nobody may be reading there.
        return data

    def close(self):
        for end in self.ends:
            os.close(end)
        self.ends = []


def _read(end):
    with contextlib.suppress(OSError):
        return os.read(end, 1 << 16)
    return b""


class SerialFlight:
    """A vehicle on a serial line whose clock is that of the simulation, and one client beside."""

    def __init__(self, flight, path, baud):
        self.flight = flight
        self.now_s = 0.0
        line = SerialLine(path=str(path), baud=baud)
        self.link = SerialLink(line, profile="onboard", now_s=lambda: self.now_s)
        self.beside = InProcessLink()
        self.server = MavlinkServer(
            flight.autopilot, flight.plant, flight.frame, [self.link, self.beside]
        )
        self.beside.client.recv()

    def tick(self):
        self.flight.plant.advance()
        self.server.update()
        self.now_s += TICK_S

    @property
    def is_alive(self):
        """Whether the client beside still hears the vehicle."""
        self.beside.client.recv()
        for _ in range(60):
            self.tick()
        return bool(named(Wire().decode(self.beside.client.recv()), "HEARTBEAT"))


@pytest.fixture
def cable():
    cable = Cable()
    yield cable
    cable.close()


@pytest.fixture
def connect(flight):
    opened = []

    def connect(path, baud=57_600):
        opened.append(SerialFlight(flight, path, baud))
        return opened[-1]

    yield connect
    for each in opened:
        each.server.close()
        each.server.close()


def test_pymavlink_reads_all_parameters_and_commands_over_a_line(cable, connect):
    serial = connect(cable.paths[0], 460_800)
    client = mavutil.mavlink_connection(cable.paths[1], baud=460_800, source_system=255)
    came = []

    def until(is_done):
        for _ in range(400):
            serial.tick()
            cable.carry()
            while (message := client.recv_match()) is not None:
                came.append(message)
            if is_done():
                return
        raise AssertionError(f"only {[message.get_type() for message in came]}")

    until(lambda: named(came, "HEARTBEAT"))
    client.mav.param_request_list_send(1, 1)
    n_parameters = len(serial.flight.autopilot.parameters)
    until(lambda: len({m.param_id for m in named(came, "PARAM_VALUE")}) == n_parameters + 1)
    client.mav.command_long_send(1, 1, 520, 0, 1, 0, 0, 0, 0, 0, 0)
    until(lambda: named(came, "COMMAND_ACK") and named(came, "AUTOPILOT_VERSION"))
    assert not named(came, "BAD_DATA")
    client.close()


@pytest.mark.parametrize("baud", [9600, 57_600])
def test_telemetry_comes_as_fast_as_the_line_carries_it_and_all_of_it_comes(cable, connect, baud):
    serial, wire, came = connect(cable.paths[0], baud), Wire(), []
    n_before, seconds = 0, 6.0
    for tick in range(round(seconds / TICK_S)):
        serial.tick()
        came += wire.decode(cable.carry())
        if tick * TICK_S == 2.0:
            n_before = cable.n_carried
    assert not named(came, "BAD_DATA")
    carried = (cable.n_carried - n_before) / ((seconds - 2.0) * baud / 10)
    assert 0.85 < carried < 1.02
    assert len(named(came, "HEARTBEAT")) >= seconds - 1
    n_fast = len(named(came, "ATTITUDE"))
    assert n_fast < 50 * seconds
    assert n_fast >= 4  # Each waits for its turn, and none for ever.
    assert len(named(came, "SYS_STATUS")) >= 5
    kinds = {message.get_type() for message in came}
    assert len(kinds) > 20


def test_a_peer_that_does_not_read_costs_its_own_line_alone(cable, connect):
    serial = connect(cable.paths[0])
    for _ in range(20):
        assert serial.is_alive
    assert len(serial.link._unsent) < 16_384
    wire, came = Wire(), []
    for _ in range(400):
        serial.tick()
        came += wire.decode(cable.carry())
    assert len(named(came, "HEARTBEAT")) >= 7
    assert not named(came, "BAD_DATA")  # Frames were dropped whole.


def test_a_device_that_goes_away_is_told_and_opened_again(connect, tmp_path, caplog):
    port = tmp_path / "port"
    first = Cable()
    port.symlink_to(first.paths[0])
    serial = connect(port)
    (channel,) = serial.link.channels
    first.close()
    assert serial.is_alive
    assert serial.link.channels == ()
    assert not channel.is_open
    assert caplog.messages == [f"serial:{port} is gone; it is opened again when it is back"]
    second = Cable()
    port.unlink()
    port.symlink_to(second.paths[0])
    assert serial.is_alive
    assert len(serial.link.channels) == 1
    assert named(Wire().decode(second.carry()), "HEARTBEAT")
    second.close()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("/dev/none", "cannot open serial device /dev/none: No such file"),
        ("/dev/null", "/dev/null is no serial device"),
        ("/dev/ttyS0:1234", "1234 baud is unknown; valid: 9600, "),
    ],
)
def test_what_is_no_serial_device_or_speed_is_named(flight, text, complaint):
    with pytest.raises(LinkError, match=complaint):
        MavlinkServer(
            flight.autopilot, flight.plant, flight.frame, [SerialLink(SerialLine.parse(text))]
        )


def test_a_line_is_a_path_with_a_speed_or_without():
    assert SerialLine.parse("/dev/ttyACM0") == SerialLine(path="/dev/ttyACM0", baud=57_600)
    assert SerialLine.parse("/dev/ttyACM0:921600").baud == 921_600
    assert SerialLine.parse("/dev/serial/by-id/usb:0:9600").path == "/dev/serial/by-id/usb:0"
