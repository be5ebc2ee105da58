"""World, vehicles, sensors, autopilot and MAVLink: everything that is simulated.

The names of `__all__` are the public ones; docs/python.md shows them at work. Each is imported when
it is first used, so that a program pays only for the parts that it needs.
"""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

if TYPE_CHECKING:
    from autonomy import ControlLevel, FlatReference, QuadrotorParams, RotorParams, Setpoint, State
    from flightsim.cameras import CameraError, Cameras, RgbdFrame, depth_noise
    from flightsim.environment.traffic import TrafficCfg
    from flightsim.environment.wind import WindCfg
    from flightsim.lidars import Lidar, LidarError, LidarScan, lidar_by_name
    from flightsim.mavlink.client import (
        PX4_HOLD,
        PX4_LAND,
        PX4_OFFBOARD,
        PX4_RETURN,
        BytePipe,
        Command,
        MavlinkClient,
        Telemetry,
    )
    from flightsim.plant import NotAlignedError, PhysicsDivergedError, Plant, PlantCfg, PlantError
    from flightsim.sensors.optical_flow import OpticalFlowCfg
    from flightsim.simulator import Controller, Simulator
    from flightsim.testbench import Testbench, TestbenchCfg, TestbenchError
    from flightsim.vehicles import (
        Airframe,
        AirframeError,
        BatteryParams,
        BodyMesh,
        BodyModel,
        CameraMount,
        airframe_by_name,
    )
    from flightsim.world import World, WorldError, build_world
else:
    __getattr__, __dir__ = public_names(__name__, __file__)

__all__ = [
    "PX4_HOLD",
    "PX4_LAND",
    "PX4_OFFBOARD",
    "PX4_RETURN",
    "Airframe",
    "AirframeError",
    "BatteryParams",
    "BodyMesh",
    "BodyModel",
    "BytePipe",
    "CameraError",
    "CameraMount",
    "Cameras",
    "Command",
    "ControlLevel",
    "Controller",
    "FlatReference",
    "Lidar",
    "LidarError",
    "LidarScan",
    "MavlinkClient",
    "NotAlignedError",
    "OpticalFlowCfg",
    "PhysicsDivergedError",
    "Plant",
    "PlantCfg",
    "PlantError",
    "QuadrotorParams",
    "RgbdFrame",
    "RotorParams",
    "Setpoint",
    "Simulator",
    "State",
    "Telemetry",
    "Testbench",
    "TestbenchCfg",
    "TestbenchError",
    "TrafficCfg",
    "WindCfg",
    "World",
    "WorldError",
    "airframe_by_name",
    "build_world",
    "depth_noise",
    "lidar_by_name",
]
