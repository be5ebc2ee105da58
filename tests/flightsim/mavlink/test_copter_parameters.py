"""ArduCopter's parameters: its ranges, defaults and choices, and what they do here."""

import pytest

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ARDUPILOT
from tests.flightsim.mavlink.test_personalities import copter
from tests.flightsim.mavlink.wire import named

__all__ = ["copter"]

_BOUNDED = [alias for alias in ARDUPILOT.aliases if alias.valid]
_CHOSEN = [alias for alias in ARDUPILOT.aliases if alias.codes]


def _set(copter, name, value):
    """Set a parameter; the value that the vehicle tells, and what it says."""
    copter.send("PARAM_SET", 1, 1, name.encode(), value, mav.MAV_PARAM_TYPE_REAL32)
    came = copter.step(2)
    (told,) = named(came, "PARAM_VALUE")
    return told.param_value, "".join(m.text for m in named(came, "STATUSTEXT"))


def _get(copter, name):
    copter.send("PARAM_REQUEST_READ", 1, 1, name.encode(), -1)
    return named(copter.step(2), "PARAM_VALUE")[-1].param_value


def test_the_vehicle_starts_with_arducopters_defaults(copter):
    defaults = {a.name: a.default for a in ARDUPILOT.aliases if a.default is not None}
    assert {name: _get(copter, name) for name in defaults} == pytest.approx(defaults)


@pytest.mark.parametrize("alias", _BOUNDED, ids=lambda alias: alias.name)
def test_the_ends_of_a_range_are_taken_and_kept(copter, alias):
    for value in (*alias.valid, *alias.special):
        assert _set(copter, alias.name, value) == (pytest.approx(value), "")
        assert _get(copter, alias.name) == pytest.approx(value)


@pytest.mark.parametrize("alias", _BOUNDED, ids=lambda alias: alias.name)
def test_beyond_its_range_a_value_is_refused_in_the_stacks_own_unit(copter, alias):
    before = _get(copter, alias.name)
    least, most = alias.valid
    told, text = _set(copter, alias.name, most + 1)
    assert told == before
    assert text.startswith(f"{alias.name} = {most + 1:g} is refused: valid are ")
    assert f"from {least:g} to {most:g} {alias.unit}" in text
    assert alias.ours == alias.name or alias.ours not in text


@pytest.mark.parametrize("alias", _CHOSEN, ids=lambda alias: alias.name)
def test_every_choice_is_taken_and_read_back_as_it_was_set(copter, alias):
    for choice, ours in alias.codes.items():
        assert _set(copter, alias.name, choice) == (choice, "")
        assert _get(copter, alias.name) == choice
        assert copter.autopilot.parameters[alias.ours] == ours


def test_zero_never_disarms_and_stands_for_the_climb_of_the_sticks(copter):
    parameters = copter.autopilot.parameters
    _set(copter, "DISARM_DELAY", 0)
    assert parameters["COM_DISARM_PRFLT"] == -1
    _set(copter, "PILOT_SPEED_DN", 0)
    _set(copter, "PILOT_SPEED_UP", 400)
    assert parameters["MPC_Z_VEL_MAX_DN"] == 4.0
    assert _get(copter, "PILOT_SPEED_DN") == 0
    _set(copter, "PILOT_SPEED_DN", 150)
    _set(copter, "PILOT_SPEED_UP", 300)
    assert parameters["MPC_Z_VEL_MAX_DN"] == 1.5


def test_the_speeds_of_the_sticks_do_not_bound_waypoints(copter):
    _set(copter, "PILOT_SPEED_UP", 50)
    _set(copter, "WPNAV_SPEED_UP", 1000)
    _set(copter, "WPNAV_SPEED", 2000)
    limits = copter.autopilot._flight.limits.automatic
    assert (limits.speed_up_mps, limits.speed_xy_mps) == (10.0, 20.0)


def test_the_fence_follows_its_parameter_and_the_parameter_the_command(copter):
    assert _get(copter, "FENCE_ENABLE") == 0
    assert _set(copter, "FENCE_ENABLE", 1) == (1, "")
    assert copter.autopilot.fence.is_enabled
    assert copter.command(mav.MAV_CMD_DO_FENCE_ENABLE, 0) == mav.MAV_RESULT_ACCEPTED
    assert _get(copter, "FENCE_ENABLE") == 0
    told, text = _set(copter, "FENCE_ENABLE", 2)
    assert (told, text) == (0, "FENCE_ENABLE = 2 is no choice; valid are 0, 1")


def test_a_hardware_type_of_receiver_is_the_simulated_one(copter):
    for number in (2, 100, 1, 14, 0):
        assert _set(copter, "GPS_TYPE", number) == (number, "")
        assert _get(copter, "GPS_TYPE") == number
    assert "is no choice; valid are 0, 1, 2, 14, 100" in _set(copter, "GPS_TYPE", 9)[1]


@pytest.mark.parametrize(
    ("name", "default", "also"),
    [
        ("LAND_SPEED", 50, (30, 200)),
        ("RTL_ALT", 1500, (200, 20000, 300000)),
        ("RTL_LOIT_TIME", 5000, (0, 60000)),
        ("FS_GCS_TIMEOUT", 5, (2, 3, 120)),
        ("FS_GCS_ENABLE", 0, (1, 2, 7)),
        ("PILOT_SPEED_UP", 250, (50, 500)),
        ("PILOT_SPEED_DN", 0, (0, 450, 500)),
        ("WPNAV_SPEED", 1000, (10, 100, 2000)),
        ("WPNAV_SPEED_UP", 250, (10, 1000)),
        ("WPNAV_SPEED_DN", 150, (10, 500)),
        ("WPNAV_RADIUS", 200, (5, 1000)),
        ("LOIT_SPEED", 1250, (20, 3500)),
        ("DISARM_DELAY", 10, (0, 127)),
        ("FENCE_ACTION", 1, (0, 2, 3, 4, 5)),
        ("FENCE_RADIUS", 300, (30, 10000)),
        ("FENCE_ALT_MAX", 100, (10, 1000)),
        ("ANGLE_MAX", 3000, (1000, 8000)),
        ("GUID_TIMEOUT", 3, (0.1, 5)),
    ],
)
def test_values_that_arducopter_documents_are_taken(copter, name, default, also):
    assert _get(copter, name) == pytest.approx(default)
    for value in also:
        assert _set(copter, name, value) == (pytest.approx(value), "")
