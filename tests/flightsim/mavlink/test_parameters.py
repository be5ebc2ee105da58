"""The parameter protocol as ground stations use it."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.autopilot.parameters import Parameters
from flightsim.mavlink.parameters import ParameterService, parameter_hash
from flightsim.mavlink.service import Partners
from flightsim.mavlink.statustext import StatustextSender
from tests.flightsim.mavlink.wire import Loop, named

_INT32, _REAL32 = 6, 9


class _Bench:
    """A parameter service with one partner."""

    def __init__(self):
        self.parameters = Parameters()
        self.loop = Loop()
        partners = Partners()
        partners.channels = [self.loop.channel]
        self.service = ParameterService(self.parameters, partners, StatustextSender(partners))

    def ask(self, name, *values):
        for message in self.loop.deliver(name, *values):
            self.service.handlers[name](self.loop.channel, message)
        return self.loop.answers()


def _as_float(value: int) -> float:
    return struct.unpack("<f", struct.pack("<i", value))[0]


def _as_int(value: float) -> int:
    return struct.unpack("<i", struct.pack("<f", value))[0]


def test_a_list_goes_out_in_pieces_with_every_index_once():
    bench = _Bench()
    messages = bench.ask("PARAM_REQUEST_LIST", 1, 1)
    assert [message.param_id for message in messages] == ["_HASH_CHECK"]
    n_ticks, listed = 0, []
    while len(listed) < len(bench.parameters):
        bench.service.update(bench.loop.channel)
        piece = bench.loop.answers()
        assert 0 < len(piece) <= 8
        listed += piece
        n_ticks += 1
    bench.service.update(bench.loop.channel)
    assert bench.loop.answers() == []
    assert [message.param_index for message in listed] == list(range(len(bench.parameters)))
    assert [message.param_id for message in listed] == list(bench.parameters)
    assert {message.param_count for message in listed} == {len(bench.parameters)}


def test_integers_travel_bytewise_and_floats_as_they_are():
    bench = _Bench()
    (message,) = bench.ask("PARAM_REQUEST_READ", 1, 1, b"SYS_AUTOSTART", -1)
    assert (message.param_type, _as_int(message.param_value)) == (_INT32, 10016)
    (message,) = bench.ask("PARAM_REQUEST_READ", 1, 1, b"MIS_TAKEOFF_ALT", -1)
    assert (message.param_type, message.param_value) == (_REAL32, 2.5)


def test_reading_by_index_finds_the_same_parameter():
    bench = _Bench()
    (by_index,) = bench.ask("PARAM_REQUEST_READ", 1, 1, b"", 3)
    assert by_index.param_id == bench.parameters.name_at(3)


@given(value=st.floats(0.0, 80.0, width=32))
def test_a_float_that_is_set_is_answered_and_kept(value):
    bench = _Bench()
    (message,) = bench.ask("PARAM_SET", 1, 1, b"MIS_TAKEOFF_ALT", value, _REAL32)
    assert message.param_value == value == bench.parameters["MIS_TAKEOFF_ALT"]


@pytest.mark.parametrize(
    ("wire_value", "wire_type"), [(_as_float(3), _INT32), (3.0, _REAL32)], ids=["bytes", "cast"]
)
def test_an_integer_is_understood_bytewise_and_cast(wire_value, wire_type):
    bench = _Bench()
    (message,) = bench.ask("PARAM_SET", 1, 1, b"NAV_DLL_ACT", wire_value, wire_type)
    assert _as_int(message.param_value) == 3 == bench.parameters["NAV_DLL_ACT"]


@pytest.mark.parametrize(
    ("name", "value", "wire_type", "error"),
    [
        (b"MIS_TAKEOFF_ALT", 1e6, _REAL32, 2),
        (b"MIS_TAKEOFF_ALT", float("nan"), _REAL32, 2),
        (b"NAV_DLL_ACT", _as_float(-7), _INT32, 2),
        (b"NAV_DLL_ACT", 1.5, _REAL32, 2),
        (b"NAV_DLL_ACT", 1e30, _REAL32, 2),
        (b"SYS_AUTOSTART", _as_float(1), _INT32, 5),
    ],
)
def test_a_refused_value_is_answered_with_the_old_one_and_the_reason(name, value, wire_type, error):
    bench = _Bench()
    old = bench.parameters[name.decode()]
    messages = bench.ask("PARAM_SET", 1, 1, name, value, wire_type)
    assert bench.parameters[name.decode()] == old
    (refusal,) = named(messages, "PARAM_ERROR")
    assert (refusal.param_id, refusal.error) == (name.decode(), error)
    assert (refusal.target_system, refusal.target_component) == (255, 190)
    assert [message.param_id for message in named(messages, "PARAM_VALUE")] == [name.decode()]
    assert name.decode() in "".join(message.text for message in named(messages, "STATUSTEXT"))


@pytest.mark.parametrize("param_id", [b"NO_SUCH_PARAM", b"", b"\xff" * 16, b"A" * 16])
def test_unknown_names_are_answered_as_such(param_id):
    bench = _Bench()
    for question in (
        ("PARAM_REQUEST_READ", 1, 1, param_id, -1),
        ("PARAM_SET", 1, 1, param_id, 1.0, _REAL32),
    ):
        (refusal,) = bench.ask(*question)
        assert (refusal.get_type(), refusal.error) == ("PARAM_ERROR", 1)


@pytest.mark.parametrize("index", [10_000, 32_767])
def test_an_index_beyond_the_list_is_answered_as_such(index):
    (refusal,) = _Bench().ask("PARAM_REQUEST_READ", 1, 1, b"MIS_TAKEOFF_ALT", index)
    assert refusal.get_type() == "PARAM_ERROR"


def test_a_cached_list_is_recognised_by_its_hash_and_stops_the_list():
    bench = _Bench()
    (message,) = bench.ask("PARAM_REQUEST_READ", 1, 1, b"_HASH_CHECK", -1)
    assert struct.pack("<f", message.param_value) == struct.pack(
        "<I", parameter_hash(bench.parameters)
    )
    bench.ask("PARAM_REQUEST_LIST", 1, 1)
    bench.ask("PARAM_SET", 1, 1, b"_HASH_CHECK", message.param_value, 5)
    bench.service.update(bench.loop.channel)
    assert bench.loop.answers() == []


def test_the_hash_changes_with_a_value():
    parameters = Parameters()
    before = parameter_hash(parameters)
    parameters.set("MIS_TAKEOFF_ALT", 7.0)
    assert parameter_hash(parameters) != before


def test_everybody_hears_of_a_change():
    bench = _Bench()
    other = Loop()
    partners = Partners()
    partners.channels = [bench.loop.channel, other.channel]
    bench.service = ParameterService(bench.parameters, partners, StatustextSender(partners))
    bench.ask("PARAM_SET", 1, 1, b"MIS_TAKEOFF_ALT", 4.0, _REAL32)
    assert [message.param_value for message in other.answers()] == [4.0]
