import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.autopilot.parameters import (
    PARAMETER_SPECS,
    ParameterError,
    Parameters,
    ParameterValueError,
    ReadOnlyParameterError,
    UnknownParameterError,
)

specs = st.sampled_from(PARAMETER_SPECS)


def test_indices_names_and_iteration_agree():
    parameters = Parameters()
    assert list(parameters) == sorted(parameters)
    assert len(parameters) == len(PARAMETER_SPECS)
    for index, name in enumerate(parameters):
        assert parameters.index(name) == index
        assert parameters.name_at(index) == name


@pytest.mark.parametrize("spec", PARAMETER_SPECS, ids=lambda spec: spec.name)
def test_each_parameter_is_well_formed(spec):
    assert len(spec.name) <= 16
    assert spec.minimum <= spec.default <= spec.maximum
    assert spec.description
    assert isinstance(Parameters()[spec.name], int if spec.type == "int" else float)


@given(specs, st.floats(allow_nan=True, allow_infinity=True))
def test_a_value_is_stored_as_the_wire_carries_it_or_refused_and_nothing_changes(spec, value):
    parameters, words = Parameters(), ""
    try:
        stored = parameters.set(spec.name, value)
    except ParameterError as error:
        stored = None
        words = str(error)
    if stored is None:
        assert spec.name in words
        assert parameters[spec.name] == spec.default
        return
    assert spec.minimum <= stored <= spec.maximum
    assert parameters[spec.name] == stored
    code = "<f" if spec.type == "float" else "<i"
    assert struct.unpack(code, struct.pack(code, stored))[0] == stored


@given(specs.filter(lambda spec: not spec.is_read_only), st.data())
def test_every_value_within_the_bounds_is_accepted(spec, data):
    if spec.type == "int":
        value = data.draw(st.integers(int(spec.minimum), int(spec.maximum)))
    else:
        value = data.draw(st.floats(spec.minimum, spec.maximum, width=32))
    assert Parameters().set(spec.name, value) == value


@pytest.mark.parametrize(
    ("name", "value", "error", "words"),
    [
        ("MIS_TAKEOFF_ALT", math.nan, ParameterValueError, "not a number"),
        ("MIS_TAKEOFF_ALT", math.inf, ParameterValueError, "not a number"),
        ("MIS_TAKEOFF_ALT", 81.0, ParameterValueError, "0 to 80 m"),
        ("NAV_DLL_ACT", 1.5, ParameterValueError, "not whole"),
        ("NAV_DLL_ACT", 1e300, ParameterValueError, "out of range"),
        ("MAV_TYPE", 3, ReadOnlyParameterError, "read-only"),
        ("NO_SUCH", 1.0, UnknownParameterError, "NO_SUCH"),
    ],
)
def test_bad_values_are_refused_by_name(name, value, error, words):
    with pytest.raises(error, match=words):
        Parameters().set(name, value)


@pytest.mark.parametrize("index", [-1, len(PARAMETER_SPECS)])
def test_an_index_out_of_range_is_refused(index):
    with pytest.raises(UnknownParameterError, match="valid are 0 to"):
        Parameters().name_at(index)


def test_a_read_only_parameter_may_be_set_to_what_it_is():
    assert Parameters(MAV_SYS_ID=3).set("MAV_SYS_ID", 3) == 3


def test_listeners_hear_changes_and_only_those():
    parameters = Parameters()
    heard = []
    parameters.add_listener(lambda spec, value: heard.append((spec.name, value)))
    parameters.set("MIS_TAKEOFF_ALT", 2.5)
    parameters.set("MIS_TAKEOFF_ALT", 5.0)
    parameters.reset()
    assert heard == [("MIS_TAKEOFF_ALT", 5.0), ("MIS_TAKEOFF_ALT", 2.5)]


def test_reset_returns_to_the_values_of_the_airframe():
    parameters = Parameters(BAT_LOW_THR=0.3)
    parameters.set("BAT_LOW_THR", 0.5)
    parameters.reset("BAT_LOW_THR")
    assert parameters["BAT_LOW_THR"] == pytest.approx(0.3)
