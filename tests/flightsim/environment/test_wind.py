"""Wind: what it is told as, what is refused, and what of it reaches the air."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.environment.dryden import stationary_states
from flightsim.environment.wind import (
    TURBULENCE_MPS,
    WindCfg,
    WindError,
    move_air,
    new_air,
    set_wind,
    turbulence_mps,
)

STILL = np.zeros(3)
OPEN = np.zeros((0, 8))
UNSHELTERED = np.zeros((1, 1, 1, 3))


def air_of(cfg, seed=0, dt_s=0.004):
    airs = new_air(dt_s)
    airs["states"][0] = stationary_states(np.random.default_rng(seed))
    set_wind(airs[0], cfg, has_rooms=True)
    return airs[0]


def blow(air, n, *, height_m=10.0, normals=None, rooms=OPEN):
    """Velocities of the air over n ticks."""
    position = np.array([0.0, 0.0, height_m])
    wind = np.array(air["steady_enu_mps"])
    rows = []
    for k in range(n):
        noise = np.zeros(5) if normals is None else normals[k]
        move_air(air, position, height_m, STILL, rooms, UNSHELTERED, noise, wind)
        rows.append(wind.copy())
    return np.array(rows)


def test_wind_comes_from_where_it_is_said_to():
    east = WindCfg(speed_mps=5.0, from_deg=90.0)
    np.testing.assert_allclose(east.steady_enu_mps, (-5.0, 0.0, 0.0), atol=1e-12)
    north = WindCfg(speed_mps=5.0)
    np.testing.assert_allclose(north.steady_enu_mps, (0.0, -5.0, 0.0), atol=1e-12)


@given(st.tuples(*[st.floats(-12, 12)] * 3))
def test_a_wind_by_its_velocity_blows_with_it(velocity):
    np.testing.assert_allclose(WindCfg.towards(velocity).steady_enu_mps, velocity, atol=1e-9)


@pytest.mark.parametrize(
    ("field", "value", "valid"),
    [
        ("speed_mps", math.nan, "at most 30 m/s"),
        ("speed_mps", 40.0, "at most 30 m/s"),
        ("speed_mps", -3.0, "0 to 30 m/s"),
        ("turbulence_mps", -1.0, "0 to 5 m/s"),
        ("gust_mps", math.inf, "0 to 20 m/s"),
        ("gust_s", 0.0, "0.1 to 3600 s"),
        ("gust_period_s", 1.0, "3 to 3600 s"),
        ("from_deg", math.nan, "degrees"),
    ],
)
def test_an_impossible_wind_is_refused_with_what_is_valid(field, value, valid):
    with pytest.raises(WindError, match=valid):
        WindCfg(**{field: value})


def test_turbulence_is_told_in_words_or_numbers():
    assert turbulence_mps("severe", 0.0) == TURBULENCE_MPS["severe"]
    assert TURBULENCE_MPS["moderate"] == pytest.approx(1.543, abs=1e-3)
    assert turbulence_mps("natural", 5.0) == 0.5
    assert turbulence_mps("0.7", 5.0) == 0.7
    with pytest.raises(WindError, match="valid: none, light, moderate, severe, natural"):
        turbulence_mps("wild", 5.0)


def test_a_gust_is_one_smooth_bump_along_the_wind():
    cfg = WindCfg(speed_mps=4.0, from_deg=270.0, gust_mps=6.0, gust_s=2.0, gust_period_s=5.0)
    wind = blow(air_of(cfg), 2600)
    np.testing.assert_allclose(wind[:1249, 0], 4.0, atol=1e-9)
    assert wind[1499, 0] == pytest.approx(10.0, abs=1e-3)
    np.testing.assert_allclose(wind[1751:2490, 0], 4.0, atol=1e-9)
    assert wind[2598, 0] > 4.5
    assert np.abs(np.diff(wind[:, 0])).max() < 6.0 * math.pi / 2.0 * 0.004
    np.testing.assert_allclose(wind[:, 1:], 0.0, atol=1e-9)


def test_turbulence_has_the_wind_for_its_axis():
    cfg = WindCfg(speed_mps=5.0, from_deg=180.0, turbulence_mps=0.5)
    air = air_of(cfg)
    wind = blow(air, 1)[0]
    along, left, up = air["turbulence_wind_mps"]
    np.testing.assert_allclose(wind, (-left, 5.0 + along, up), atol=1e-12)


def test_turbulence_is_as_strong_as_asked_for():
    cfg = WindCfg(speed_mps=10.0, from_deg=270.0, turbulence_mps=1.0)
    n = 40_000
    normals = np.random.default_rng(3).standard_normal((n, 5))
    wind = blow(air_of(cfg, dt_s=0.02), n, height_m=6.096, normals=normals)
    # At 20 ft the horizontal ones are (0.177 + 0.000823 * 20)^-0.4 times the vertical one.
    assert wind[:, 2].std() == pytest.approx(1.0, rel=0.1)
    assert wind[:, 0].std() == pytest.approx(1.929, rel=0.15)
    assert wind[:, 1].std() == pytest.approx(1.929, rel=0.15)
    assert wind[:, 0].mean() == pytest.approx(10.0, abs=0.5)


def test_no_wind_blows_in_a_room_and_all_of_it_a_metre_away():
    air = air_of(WindCfg(speed_mps=6.0, from_deg=270.0))
    # A room of 4 m a side and its walls, 3 m high, about (0, 0, 1.5).
    room = np.array([[0.0, 0.0, 1.5, 1.0, 0.0, 2.0, 2.0, 1.5]])
    heights = {0.5: 0.0, 3.0: 0.0, 3.5: 0.5, 4.0: 1.0, 9.0: 1.0}
    for height_m, share in heights.items():
        wind = blow(air, 1, height_m=height_m, rooms=room)[-1]
        np.testing.assert_allclose(wind, (6.0 * share, 0.0, 0.0), atol=1e-12)
