"""Turns and nods keep the limits, end at rest, and a nod looks up."""

import math

import numpy as np
import pytest

from autonomy.mapping import Agenda, SeenMap
from autonomy.mapping.gestures import NOD_RAD, nod, turn
from autonomy.mapping.task import Task
from autonomy.planning import CertificateError, Craft, FlightLimits, PlannerCfg
from autonomy.types import FlatReference
from tests.autonomy.planning_worlds import quadrotor

CFG = PlannerCfg(vehicle_radius_m=0.35)
LIMITS = FlightLimits()


def task(yaw=0.0, rate=0.0, radius=4.0):
    seen = SeenMap((-6.0, -6.0, 0.0), (6.0, 6.0, 5.0))
    seen.assume_free_column((0.0, 0.0, 0.0), radius_m=radius, height_m=4.0)
    start = FlatReference(position_enu_m=(0.0, 0.0, 2.0), yaw_rad=yaw, yaw_rate_radps=rate)
    return Task(seen, Agenda(), start, (5.0, 0.0, 2.0), Craft(LIMITS, quadrotor(), CFG))


@pytest.mark.parametrize("angle", [-3.1, -0.3, 0.0, 0.2, 3.1])
@pytest.mark.parametrize("rate", [0.0, 0.15])
def test_a_turn_arrives_within_the_limits(angle, rate):
    way = turn(task(yaw=0.4, rate=rate), angle)
    yaw = way.yaw.yaw_rad
    assert yaw[-1] == pytest.approx(0.4 + angle, abs=0.03)
    rates = np.diff(yaw) / way.yaw.step_s
    assert np.abs(rates).max() <= LIMITS.yaw_rate_radps
    assert np.abs(np.diff(rates)).max() / way.yaw.step_s <= LIMITS.yaw_acceleration_radps2
    assert way.duration_s < 3.2


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_a_nod_back_tilts_the_camera_up_for_two_images(yaw):
    way = nod(task(yaw=yaw), backwards_first=True)
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    end = np.array(way.sample(way.duration_s).position_enu_m)
    assert (end - [0.0, 0.0, 2.0]) @ ahead == pytest.approx(-1.5)
    times = np.arange(0.0, way.duration_s, 0.01)
    back = [-np.array(way.sample(t).acceleration_enu_mps2) @ ahead for t in times]
    up_s = 0.01 * np.sum(np.arctan(np.array(back) / 9.81) >= NOD_RAD)
    assert up_s >= 0.4


def test_a_nod_without_room_is_refused():
    with pytest.raises(CertificateError, match="clearance"):
        nod(task(radius=1.0), backwards_first=True)
