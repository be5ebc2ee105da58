"""What PX4 is told of odometry and optical flow: when, from where, and along which axes."""

import math

import numpy as np
import pytest

from autonomy.types import yaw_of
from flightsim.bridges.physics.odometry import OdometryPoses
from flightsim.bridges.physics.px4_messages import SensorMessages
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.plant import Plant, PlantCfg
from flightsim.sensors.optical_flow import OpticalFlowCfg
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

ZURICH = Geodetic(47.4, 8.5, 488.0)
START_ENU_M, YAW = (7.0, -5.0, 0.0), 0.4


@pytest.fixture(scope="module")
def away():
    """A world in which the vehicle does not stand at the origin of the scene."""
    scene = empty_scene(start=START_ENU_M, yaw_rad=YAW)
    return build_world(scene, airframe_by_name("iris"))


def told_in_a_second(away, cfg):
    """A plant with these sensors, and what its bridge tells in a second."""
    plant, told = Plant(away, cfg), []
    messages, parser = SensorMessages(LocalFrame(ZURICH)), mavlink.MAVLink(None)
    plant.hand_over(
        lambda: told.extend(
            (plant.time_us, message) for message in parser.parse_buffer(messages.frames(plant)[0])
        )
    )
    for _ in range(50):
        plant.advance()
    return told


@pytest.fixture
def odometry(away):
    """With odometry and optical flow."""
    eye = OpticalFlowCfg(is_fitted=True)
    return told_in_a_second(away, PlantCfg(seed=1, aiding="vio", optical_flow=eye))


def test_odometry_arrives_late_and_counts_from_the_start_by_north_and_east(odometry):
    poses = [(at_us, m) for at_us, m in odometry if m.get_type() == "ODOMETRY"]
    assert len(poses) == 23  # 25 a second, but for those under way: of 0.96 s and of 1 s
    heading_rad = math.pi / 2 - YAW
    for at_us, pose in poses:
        assert at_us + 1_000_000 - pose.time_usec == 40_000
        assert (pose.frame_id, pose.estimator_type) == (
            mavlink.MAV_FRAME_LOCAL_NED,
            mavlink.MAV_ESTIMATOR_TYPE_VIO,
        )
        assert (pose.x, pose.y, pose.z) == pytest.approx((0.0, 0.0, 0.0), abs=0.06)
        w, x, y, z = pose.q
        assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-3)
        assert 2.0 * math.atan2(z, w) == pytest.approx(heading_rad, abs=0.02)
        assert pose.pose_covariance[0] == pytest.approx(1e-4)
        assert pose.pose_covariance[20] == pytest.approx(1.6e-5)
        assert math.isnan(pose.vx)


def test_odometry_turns_with_the_start(away):
    plant = Plant(away, PlantCfg(seed=1, aiding="vio"))
    poses = OdometryPoses()
    assert poses.arrived(plant) is None
    plant._record["vio"]["tick"] = 10
    plant._record["vio"]["position_vio_m"] = (2.0, 1.0, 0.5)  # forward, left, up
    plant._record["vio"]["yaw_vio_rad"] = 0.3
    plant._read_afresh()
    assert poses.arrived(plant) is None  # It is under way.
    for _ in range(4):
        plant._record["vio"]["is_enabled"] = 0
        plant.advance()
        if (pose := poses.arrived(plant)) is not None:
            break
    assert pose is not None
    forward, left = (
        np.array((math.cos(YAW), math.sin(YAW))),
        np.array((-math.sin(YAW), math.cos(YAW))),
    )
    assert pose.from_start_enu_m[:2] == pytest.approx(2.0 * forward + left)
    assert pose.from_start_enu_m[2] == pytest.approx(0.5)
    assert yaw_of(pose.quat_wxyz) == pytest.approx(YAW + 0.3, abs=1e-6)


def test_optical_flow_is_told_where_it_is_fitted(away, odometry):
    flows = [m for _, m in odometry if m.get_type() == "HIL_OPTICAL_FLOW"]
    assert len(flows) == 49
    assert flows[-1].integration_time_us == 20_000
    assert flows[-1].quality == 255
    assert 0.0 < flows[-1].distance < 0.3
    without = told_in_a_second(away, PlantCfg(seed=1))
    assert not {"ODOMETRY", "HIL_OPTICAL_FLOW"} & {m.get_type() for _, m in without}
