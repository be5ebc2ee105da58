import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.vehicles.battery import Battery, BatteryError, cell_voltage_v
from flightsim.vehicles.catalogue import AIRFRAMES

IRIS = AIRFRAMES["iris"].battery
HOVER = (IRIS.hover_rotor_speed_radps,) * 4
CHARGE = st.floats(0.0, 1.0)
SPEED = st.floats(0.0, 1100.0)


def fly_until_empty(params, dt_s=1.0):
    battery = Battery(params)
    seconds = 0.0
    while battery.remaining > 0 and seconds < 7200:
        battery.step((params.hover_rotor_speed_radps,) * 4, dt_s)
        seconds += dt_s
    return seconds


@given(CHARGE, CHARGE)
def test_open_circuit_voltage_grows_with_charge(a, b):
    low, high = sorted((a, b))
    assert 3.2 < cell_voltage_v(low) <= cell_voltage_v(high) <= 4.2


def test_full_pack_at_rest_has_its_cells_voltage():
    assert Battery(IRIS).voltage_v == pytest.approx(3 * 4.2)


@pytest.mark.parametrize("charge", [1.0, 0.5, 0.1])
def test_terminal_power_is_what_rotors_and_avionics_ask(charge):
    battery = Battery(IRIS, charge)
    battery.step(HOVER, 0.02)
    asked_w = IRIS.hover_power_w + IRIS.avionics_power_w
    assert battery.voltage_v * battery.current_a == pytest.approx(asked_w)
    assert battery.voltage_v < 3 * cell_voltage_v(charge)


def test_power_grows_with_the_cube_of_speed():
    powers = []
    for factor in (0.5, 1.0):
        battery = Battery(IRIS)
        battery.step(tuple(factor * w for w in HOVER), 0.02)
        powers.append(battery.voltage_v * battery.current_a - IRIS.avionics_power_w)
    assert powers[1] / powers[0] == pytest.approx(8.0)


@given(st.tuples(SPEED, SPEED, SPEED, SPEED), CHARGE)
def test_charge_only_falls_and_voltage_stays_positive(speeds, charge):
    battery = Battery(IRIS, charge)
    before = battery.remaining
    battery.step(speeds, 0.02)
    assert 0.0 <= battery.remaining <= before
    assert 0.0 < battery.voltage_v < 12.7
    assert battery.current_a > 0.0


@given(CHARGE)
def test_load_beyond_the_pack_gets_its_greatest_power(charge):
    weak = dataclasses.replace(IRIS, internal_resistance_ohm=1.0)
    battery = Battery(weak, charge)
    battery.step(HOVER, 0.02)
    assert battery.voltage_v == pytest.approx(3 * cell_voltage_v(charge) / 2)


def test_consumed_charge_and_remaining_add_up():
    battery = Battery(IRIS, 0.8)
    for _ in range(100):
        battery.step(HOVER, 1.0)
    assert battery.remaining == pytest.approx(0.8 - battery.consumed_mah / IRIS.capacity_mah)


@pytest.mark.parametrize(
    ("name", "low_min", "high_min"), [("iris", 9, 16), ("hummingbird", 14, 24)]
)
def test_hover_endurance_is_that_of_the_real_machine(name, low_min, high_min):
    assert low_min < fly_until_empty(AIRFRAMES[name].battery) / 60 < high_min


def test_empty_pack_stays_empty():
    battery = Battery(IRIS, 0.0)
    battery.step(HOVER, 10.0)
    assert battery.remaining == 0.0
    assert battery.consumed_mah == 0.0


@pytest.mark.parametrize("charge", [-0.1, 1.1, float("nan")])
def test_impossible_charge_is_refused(charge):
    with pytest.raises(BatteryError, match=r"state_of_charge .* is outside 0 to 1"):
        Battery(IRIS, charge)
