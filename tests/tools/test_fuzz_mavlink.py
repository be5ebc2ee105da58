"""The fuzzer at fixed seeds on every link, and that it sees what it is for."""

import struct

import fuzz_mavlink
import pytest
from fuzzing.clients import LINKS
from fuzzing.frames import COMMANDS, Traffic
from fuzzing.values import TYPES
from fuzzing.vehicles import DeadVehicleError, Vehicle

from flightsim.mavlink import streams
from flightsim.mavlink.dialect import LAYOUTS, dialect
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.server import MavlinkServer
from tests.thorough import IS_THOROUGH

FRAMES = {
    "in-process": 30_000 if IS_THOROUGH else 10_000,
    **dict.fromkeys(("udp", "tcp", "serial", "signed"), 1_500),
}
"""What frames do is seen without a network; the other links are to carry them."""


@pytest.mark.timeout(300)
@pytest.mark.parametrize("link", LINKS)
@pytest.mark.parametrize("kind", fuzz_mavlink.KINDS)
def test_nothing_that_arrives_is_a_fault_or_moves_the_vehicle(kind, link):
    row = fuzz_mavlink.fuzz(kind, link, n_frames=FRAMES[link], seed=7, n_clients=2)
    assert row.n_frames >= FRAMES[link]
    assert row.fault is None
    assert row.is_sound, row


@pytest.fixture
def unclamped(monkeypatch):
    """Intervals as they were: any may be set, and is told as it is."""
    interval = LAYOUTS["MESSAGE_INTERVAL"]
    monkeypatch.setattr(streams, "LONGEST_US", 10**18)
    monkeypatch.setattr(
        interval,
        "encode",
        lambda **values: interval.pack(*(values[name] for name in interval.fields)),
    )


@pytest.mark.usefixtures("unclamped")
def test_a_number_that_does_not_fit_its_field_would_be_found():
    row = fuzz_mavlink.fuzz("hover", "in-process", n_frames=12_000, seed=0)
    assert row.n_faults > 0
    assert str(row.fault).startswith("struct.error")
    assert not row.is_sound


@pytest.mark.usefixtures("unclamped")
def test_without_the_guard_it_would_end_the_flight(monkeypatch):
    monkeypatch.setattr(Faults, "__exit__", lambda *_: False)
    with pytest.raises(struct.error):
        fuzz_mavlink.fuzz("hover", "in-process", n_frames=12_000, seed=0)


def test_a_vehicle_that_no_longer_answers_is_noticed(monkeypatch):
    vehicle = Vehicle("in-process")
    vehicle.require_life()
    monkeypatch.setattr(MavlinkServer, "_dispatch", lambda *_: None)
    with pytest.raises(DeadVehicleError):
        vehicle.require_life()
    vehicle.close()


def test_every_message_and_every_command_is_sent():
    frames = Traffic(0, is_obeyed=True).frames()
    decoder = dialect.MAVLink(None)
    seen, commands = set(), set()
    for _ in range(60_000):
        data = next(frames)
        if not data:
            continue
        message = decoder.decode(bytearray(data))
        seen.add(message.get_type())
        if message.get_type() in {"COMMAND_LONG", "COMMAND_INT"}:
            commands.add(message.command)
    assert seen == set(TYPES)
    assert commands >= set(COMMANDS)


def test_one_seed_is_one_traffic():
    first, again, other = (Traffic(seed, is_obeyed=False).frames() for seed in (1, 1, 2))
    drawn = [[next(frames) for _ in range(200)] for frames in (first, again, other)]
    assert drawn[0] == drawn[1] != drawn[2]
