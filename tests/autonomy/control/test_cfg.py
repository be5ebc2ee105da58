"""Gains: what inertia, lag and torque make of them."""

import math
from dataclasses import replace

import pytest

from autonomy.control.cfg import controller_cfg_for
from tests.autonomy.sample_quadrotors import IRIS, PLUS, ring


def lagging(vehicle, seconds):
    rotors = (replace(r, time_constant_down_s=seconds) for r in vehicle.rotors)
    return replace(vehicle, rotors=tuple(rotors))


def test_inertia_sets_the_bandwidth_of_a_vehicle_with_quick_rotors():
    cfg = controller_cfg_for(IRIS)
    assert cfg.attitude_bandwidth_radps == 1.7 / math.sqrt(0.029)
    assert cfg.position_bandwidth_radps == 0.4 * cfg.attitude_bandwidth_radps
    assert cfg.rotor_response_s == 0.0125
    heavy = replace(ring(8), inertia_flu_kgm2=(0.2, 0.2, 0.3))
    assert controller_cfg_for(heavy).attitude_bandwidth_radps == 7.0


@pytest.mark.parametrize(("lag_s", "bandwidth"), [(0.025, 16.0), (0.05, 8.0), (0.1, 4.0)])
def test_slow_rotors_slow_the_attitude(lag_s, bandwidth):
    light = replace(PLUS, inertia_flu_kgm2=(0.001, 0.001, 0.002))
    cfg = controller_cfg_for(lagging(light, lag_s))
    assert cfg.attitude_bandwidth_radps == pytest.approx(bandwidth)
    assert cfg.rotor_response_s == 0.5 * lag_s


def test_an_error_of_0_4_rad_takes_what_the_rotors_can_add():
    weak = replace(IRIS, mass_kg=2.4, inertia_flu_kgm2=(0.05, 0.05, 0.08))
    room_n = 5.84e-6 * 1100.0**2 - 2.4 * 9.81 / 4
    torque_nm = 4 * 0.13 * room_n
    bandwidth = controller_cfg_for(weak).attitude_bandwidth_radps
    assert 0.05 * bandwidth**2 * 0.4 == pytest.approx(torque_nm)
