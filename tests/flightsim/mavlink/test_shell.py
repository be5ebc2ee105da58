"""The shell over SERIAL_CONTROL."""

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ARDUPILOT
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

SHELL, RESPOND = mav.SERIAL_CONTROL_DEV_SHELL, mav.SERIAL_CONTROL_FLAG_RESPOND


def send(flight, text):
    data = text.encode()
    flight.send("SERIAL_CONTROL", SHELL, RESPOND, 0, 0, len(data), list(data.ljust(70, b"\0")))


def printed(flight, ticks=30):
    answers = named(flight.step(ticks), "SERIAL_CONTROL")
    assert all(m.flags == mav.SERIAL_CONTROL_FLAG_REPLY for m in answers)
    return b"".join(bytes(m.data[: m.count]) for m in answers).decode()


def ask(flight, line):
    send(flight, line + "\n")
    return printed(flight).removesuffix("nsh> ").rstrip()


def test_help_names_every_command(flight):
    text = ask(flight, "help")
    assert [line.split()[0] for line in text.splitlines()] == [
        *("help", "ver", "param", "commander", "listener")
    ]


def test_a_line_may_come_in_pieces_and_is_answered_once_it_ends(flight):
    send(flight, "param show MIS_TAKE")
    assert not printed(flight)
    send(flight, "OFF_ALT\n")
    assert printed(flight) == "MIS_TAKEOFF_ALT: 2.5\nnsh> "


def test_parameters_are_shown_by_pattern_and_set(flight):
    assert len(ask(flight, "param show RTL_*").splitlines()) == 5
    assert ask(flight, "param set RTL_RETURN_ALT 21") == "RTL_RETURN_ALT: 21"
    assert flight.autopilot.parameters["RTL_RETURN_ALT"] == 21.0
    assert "out of range" in ask(flight, "param set RTL_RETURN_ALT 1e9")
    assert "does not exist" in ask(flight, "param set NO_SUCH 1")
    assert "no number" in ask(flight, "param set RTL_RETURN_ALT high")


def test_a_long_answer_comes_whole(flight):
    text = ask(flight, "param show")
    shown = [line.split(":")[0] for line in text.splitlines()]
    assert shown == list(flight.autopilot.parameters)


def test_the_commander_arms_takes_off_and_lands(flight):
    flight.become_ready()
    assert ask(flight, "commander check") == "OK"
    assert ask(flight, "commander takeoff") == "accepted"
    flight.skip(8.0)
    assert ask(flight, "commander status") == "armed, mode Hold, in air"
    assert ask(flight, "commander disarm").startswith("temporarily rejected: ")
    assert ask(flight, "commander mode position") == "accepted"
    assert flight.autopilot.mode is Mode.POSITION
    assert ask(flight, "commander land") == "accepted"


@pytest.mark.parametrize(
    "topic",
    [
        "battery_status",
        "home_position",
        "sensor_gps",
        "vehicle_attitude",
        "vehicle_local_position",
        "vehicle_status",
    ],
)
def test_the_listener_prints_a_topic(flight, topic):
    flight.become_ready()
    first, *rest = ask(flight, f"listener {topic}").splitlines()
    assert first == f"TOPIC: {topic}"
    assert len(rest) >= 3
    assert all(": " in line for line in rest)


@pytest.mark.parametrize("line", ["rm -rf /", "commander fly", "listener", "param", "mode \xff"])
def test_a_line_that_is_no_command_is_told_so(flight, line):
    text = ask(flight, line)
    assert "command not found" in text or text.startswith("usage: ")


def test_a_line_without_end_is_cut(flight):
    for _ in range(50):
        send(flight, "x" * 70)
        flight.step()
    service = next(s for s in flight.server._stateful if hasattr(s, "_typed"))
    assert max(map(len, service._typed.values())) <= 256


def test_ardupilots_vehicle_has_none(field):
    flight = Flight(field, personality=ARDUPILOT)
    send(flight, "help\n")
    assert printed(flight) == "This vehicle has no shell.\n"
    flight.server.close()
