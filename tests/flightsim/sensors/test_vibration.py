"""Vibration: a rotor's imbalance as a slow IMU sees it, weakened and at its alias."""

import math

import numpy as np
import pytest

from flightsim.sensors.vibration import new_vibration, shake
from flightsim.vehicles.catalogue import AIRFRAMES

HZ = 250
IRIS = AIRFRAMES["iris"]


def one_rotor(*, imbalance=1e-6, ripple=0.0, is_on=True):
    v = new_vibration(IRIS, np.random.default_rng(3), dt_s=1.0 / HZ, is_on=is_on)[0]
    v["imbalance_kgm"], v["ripple_n"] = 0.0, 0.0
    v["imbalance_kgm"][0], v["ripple_n"][0] = imbalance, ripple
    return v


def samples(v, speed, n=2000):
    rows = []
    for _ in range(n):
        shake(v, np.full(4, speed))
        rows.append(np.concatenate([v["accel_flu_mps2"], v["gyro_flu_radps"]]))
    return np.array(rows)


def spectrum(signal):
    """Frequencies and amplitudes of the parts of a signal."""
    window = np.hanning(len(signal))
    return np.fft.rfftfreq(len(signal), 1.0 / HZ), 2.0 * np.abs(
        np.fft.rfft(signal * window)
    ) / np.sum(window)


@pytest.mark.parametrize("hertz", [40.0, 73.0, 128.0, 240.0])
def test_an_imbalance_shows_at_its_alias_weakened_by_the_mean(hertz):
    """U w^2 / m, times sin(x) / x of half the turn in an interval."""
    speed = 2.0 * math.pi * hertz
    accel = samples(one_rotor(), speed)[:, 0]
    at_hz, amplitude = spectrum(accel)
    alias_hz = abs(hertz - HZ * round(hertz / HZ))
    assert at_hz[np.argmax(amplitude)] == pytest.approx(alias_hz, abs=0.2)
    weakened = np.sinc(hertz / HZ)  # sin(pi f T) / (pi f T)
    expected = 1e-6 * speed**2 / IRIS.quadrotor.mass_kg * weakened
    assert amplitude.max() == pytest.approx(expected, rel=0.05)


def test_the_passage_of_blades_shakes_upwards_at_twice_the_speed():
    hertz = 50.0
    speed = 2.0 * math.pi * hertz
    accel = samples(one_rotor(imbalance=0.0, ripple=1e-7), speed)
    at_hz, amplitude = spectrum(accel[:, 2])
    assert at_hz[np.argmax(amplitude)] == pytest.approx(2.0 * hertz, abs=0.2)
    expected = 1e-7 * speed**2 / IRIS.quadrotor.mass_kg * np.sinc(2.0 * hertz / HZ)
    assert amplitude.max() == pytest.approx(expected, rel=0.05)
    np.testing.assert_array_equal(accel[:, :2], 0.0)


def test_rates_are_the_integral_of_torques_about_the_centre_of_mass():
    """Slow against the IMU's rate, means are values: J dw/dt = hub x force."""
    v = one_rotor(imbalance=1e-5, ripple=1e-6)
    rows = samples(v, 15.0, n=4000)
    hub, J = v["hub_flu_m"][0], v["inertia_flu_kgm2"]
    torque = np.cross(hub, IRIS.quadrotor.mass_kg * rows[:, :3])
    turned = np.gradient(rows[:, 3:], 1.0 / HZ, axis=0) * J
    scale = np.abs(torque).max(axis=0)
    np.testing.assert_allclose(turned[2:-2] / scale, torque[2:-2] / scale, atol=0.03)


def test_accelerations_in_hover_are_those_of_a_well_balanced_vehicle():
    """About 0.7 m/s^2 RMS along x and y before the mean, within the 3 m/s^2 that manuals allow."""
    rms = []
    for seed in range(40):
        v = new_vibration(IRIS, np.random.default_rng(seed), dt_s=1e-4, is_on=True)[0]
        rms.append(samples(v, 803.0, n=300)[:, :2].std())
    assert np.sqrt(np.mean(np.square(rms))) == pytest.approx(0.71, rel=0.15)


def test_nothing_shakes_where_nothing_turns_or_it_is_off():
    np.testing.assert_array_equal(samples(one_rotor(), 0.0, n=5), 0.0)
    np.testing.assert_array_equal(samples(one_rotor(is_on=False), 800.0, n=5), 0.0)
