"""Optical flow by the definition of OPTICAL_FLOW_RAD, from motion and rays."""

import math
from dataclasses import replace

import numpy as np
import pytest

from autonomy.types import ControlLevel, Setpoint
from flightsim.plant import Plant, PlantCfg
from flightsim.sensors.failure import Failure
from flightsim.sensors.optical_flow import (
    BEST_QUALITY,
    OPTICAL_FLOW,
    OpticalFlowCfg,
    follow_flow,
    sample_optical_flow,
)
from flightsim.sensors.sensor import SensorStart
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

HZ = 250
DT_S = 1.0 / HZ
NORTH = np.array([math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4)])
"""The nose points north."""
NOISELESS = OpticalFlowCfg(is_fitted=True, noise_radps=0.0)


def sampled(
    velocity_enu_mps=(0.0, 0.0, 0.0), rate_flu_radps=(0.0, 0.0, 0.0), seen_m=2.0, cfg=NOISELESS
):
    """A sample of a constant motion that lasts from the sample before."""
    r = OPTICAL_FLOW.new(cfg, SensorStart(tick_hz=HZ))[0]
    r["seen_m"] = seen_m
    velocity, rate = np.array(velocity_enu_mps), np.array(rate_flu_radps)
    for _ in range(r["period_ticks"]):
        follow_flow(r, NORTH, velocity, rate, rate, DT_S)
    sample_optical_flow(r, 5, r["period_ticks"] * DT_S, np.ones(2))
    return OPTICAL_FLOW.read(r, 4000)


def test_motion_forward_is_flow_about_right_and_motion_to_the_right_against_forward():
    ahead = sampled(velocity_enu_mps=(0.0, 1.0, 0.0))
    assert ahead.flow_frd_rad == pytest.approx((0.0, 0.01))  # 1 m/s at 2 m for 20 ms
    right = sampled(velocity_enu_mps=(1.0, 0.0, 0.0))
    assert right.flow_frd_rad == pytest.approx((-0.01, 0.0))
    assert ahead.integration_us == 20_000
    assert ahead.time_us == 20_000
    assert ahead.distance_m == 2.0
    assert ahead.quality == BEST_QUALITY


def test_a_turn_is_flow_as_the_gyroscope_tells_it():
    turn = sampled(rate_flu_radps=(0.5, 0.3, 0.2))
    assert turn.flow_frd_rad == pytest.approx((0.01, -0.006))
    assert turn.gyro_frd_rad == pytest.approx((0.01, -0.006, -0.004))


@pytest.mark.parametrize("seen_m", [-1.0, 0.05, 31.0])
def test_there_is_no_flow_of_what_is_not_seen(seen_m):
    reading = sampled(velocity_enu_mps=(3.0, 0.0, 0.0), seen_m=seen_m)
    assert reading.quality == 0
    assert reading.flow_frd_rad == (0.0, 0.0)
    assert math.isinf(reading.distance_m) == (seen_m != 0.05)


def test_what_passes_too_fast_is_lost():
    assert sampled(velocity_enu_mps=(0.0, 14.0, 0.0)).quality == BEST_QUALITY
    assert sampled(velocity_enu_mps=(0.0, 16.0, 0.0)).quality == 0


def test_noise_is_that_of_the_mean_rate():
    noisy = sampled(cfg=replace(NOISELESS, noise_radps=0.1))
    assert noisy.flow_frd_rad == pytest.approx((0.002, 0.002))


def test_flow_and_gyroscope_of_a_flight_give_its_velocity():
    world = build_world(empty_scene(), AIRFRAMES["iris"])
    plant = Plant(
        world, PlantCfg(seed=3, aiding="vio", optical_flow=OpticalFlowCfg(is_fitted=True))
    )
    assert plant.sensors.optical_flow.integration_us == 0
    plant.align()
    errors_mps = []
    for tick in range(400):
        target = (0.02 * tick if tick > 150 else 0.0, 0.0, 3.0)
        plant.apply(Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=target, yaw_rad=0.0))
        plant.advance()
        reading = plant.sensors.optical_flow
        if tick > 250:
            assert reading.quality == BEST_QUALITY
            seen = (reading.flow_frd_rad[1] - reading.gyro_frd_rad[1]) * reading.distance_m
            speed_mps = seen / (1e-6 * reading.integration_us)
            errors_mps.append(speed_mps - plant.truth.velocity_enu_mps[0])
    assert plant.truth.velocity_enu_mps[0] == pytest.approx(1.0, abs=0.3)
    assert abs(np.mean(errors_mps)) < 0.05
    assert 0.05 < np.std(errors_mps) < 0.4  # 0.05 rad/s at 3 m
    plant.failures.fail_sensor("optical_flow", Failure.OFF)
    before = plant.sensors.optical_flow
    plant.advance()
    assert plant.sensors.optical_flow == before


def test_a_vehicle_without_the_sensor_flies_the_same_bits():
    world = build_world(empty_scene(), AIRFRAMES["iris"])
    rows = []
    for is_fitted in (False, True):
        fitted = OpticalFlowCfg(is_fitted=is_fitted)
        plant = Plant(world, PlantCfg(seed=3, optical_flow=fitted))
        for _ in range(30):
            plant.advance()
        rows.append(plant.history.tobytes())
    assert rows[0] == rows[1]
