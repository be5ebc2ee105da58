"""What an external stack is told over its MAVLink port, besides commands."""

import math
from dataclasses import replace

import pytest

from flightsim.bridges.monitor import Monitor
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.client import REAL_PX4_HABITS
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.mavlink.personalities import PERSONALITIES
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene
from tests.scenarios.landing_scenes import thing

WALL_M = 6.0
YAW = math.pi / 2


class MemoryWire:
    """A port on which system 7 beats, and that keeps what it is sent."""

    def __init__(self):
        self.sent = b""
        self._stack = mavlink.MAVLink(None, 7, 1)

    def open(self):
        return True

    def send(self, data):
        self.sent += data

    def recv(self):
        return mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3).pack(self._stack)

    def close(self):
        pass


@pytest.fixture
def plant():
    """A vehicle that looks north, at the middle of a wall to its west."""
    wall = thing(1, "container", (-WALL_M - 0.5, 0.0, 5.0), (1.0, 30.0, 10.0))
    scene = replace(empty_scene(yaw_rad=YAW), objects=(replace(wall, scene_id="handmade"),))
    return Plant(build_world(scene, airframe_by_name("iris")), PlantCfg(seed=1))


def reports(plant):
    """Obstacle distances that a second brings."""
    wire = MemoryWire()
    frame = LocalFrame(Geodetic(47.4, 8.5, 488.0))
    names, habits = PERSONALITIES["px4"], REAL_PX4_HABITS
    monitor = Monitor(wire, plant, frame, names=names, habits=habits)
    for _ in range(50):
        plant.advance()
        monitor.update()
    messages = mavlink.MAVLink(None).parse_buffer(wire.sent)
    return [m for m in messages if m.get_type() == "OBSTACLE_DISTANCE"]


def test_the_ring_scan_comes_ten_times_a_second_from_a_sensor_of_the_vehicle(plant):
    told = reports(plant)
    assert len(told) == 10
    last = told[-1]
    assert (last.get_srcSystem(), last.get_srcComponent()) == (7, 196)
    assert (last.frame, last.increment_f) == (mavlink.MAV_FRAME_BODY_FRD, 5.0)
    left, ahead, right = last.distances[54], last.distances[0], last.distances[18]
    assert left == pytest.approx(100.0 * WALL_M, abs=10.0)
    assert ahead == right == last.max_distance + 1
