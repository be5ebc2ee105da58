"""Calls that read a vehicle's state and its sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from autonomy.types import State, Vector3, vector3
from flightsim.autopilot.modes import LandedState
from flightsim.frames import Geodetic
from flightsim.plant import Plant
from scenarios.airsim.control_calls import Find
from scenarios.airsim.craft import Craft
from scenarios.airsim.frames import attitude, floats, frd, geo, ned, stamp
from scenarios.airsim.messages import (
    Barometer,
    Collision,
    Distance,
    Environment,
    GeoPoint,
    GnssReport,
    Gps,
    Imu,
    Kinematics,
    LidarData,
    Magnetometer,
    MultirotorState,
    Pose,
    Rotor,
    RotorStates,
    Vector3r,
)
from scenarios.airsim.methods import RpcError
from scenarios.airsim.rangers import NED_FROM_ENU, SENSOR_FRAME, named, quaternion_ned

_LANDED, _FLYING = 0, 1
_NO_FIX, _FIX_3D = 0, 3
_GAS_CONSTANT = 287.05
_GAUSS_PER_UT = 0.01


class StateCalls:
    """Methods by their names in AirSim, each for the vehicle that it names."""

    def __init__(self, find: Find) -> None:
        """Read the vehicles that `find` knows by name."""
        self._find = find

    @property
    def functions(self) -> Mapping[str, Callable[..., object]]:
        """All methods."""
        return {
            "getMultirotorState": self.state,
            "simGetGroundTruthKinematics": self.true_kinematics,
            "simGetPhysicsRawKinematics": self.true_kinematics,
            "simGetGroundTruthEnvironment": self.environment,
            "simGetVehiclePose": self.true_pose,
            "simGetCollisionInfo": self.collision,
            "getHomeGeoPoint": self.home,
            "getRotorStates": self.rotors,
            "getImuData": self.imu,
            "getBarometerData": self.barometer,
            "getMagnetometerData": self.magnetometer,
            "getGpsData": self.gps,
            "getDistanceSensorData": self.distance,
            "getLidarData": self.lidar,
            "simTestLineOfSightToPoint": self.sees_point,
            "simTestLineOfSightBetweenPoints": self.see_each_other,
        }

    def state(self, vehicle_name: str = "") -> MultirotorState:
        """Return the state that the autopilot reports."""
        craft = self._find(vehicle_name)
        plant, reports = craft.vehicle.plant, craft.vehicle.stack.reports
        believed = plant.estimate if plant.is_aligned else plant.truth
        is_landed = reports.landed_state is LandedState.ON_GROUND
        is_ready = bool(plant.is_aligned)
        return MultirotorState(
            collision=craft.contacts.last,
            kinematics_estimated=_kinematics(craft, believed, "est"),
            gps_location=geo(craft.vehicle.frame.geodetic_from_enu(believed.position_enu_m)),
            timestamp=stamp(plant.time_us),
            landed_state=_LANDED if is_landed else _FLYING,
            ready=is_ready,
            ready_message="" if is_ready else "the estimator is not aligned yet",
            can_arm=is_ready,
        )

    def true_kinematics(self, vehicle_name: str = "") -> Kinematics:
        """The true motion."""
        craft = self._find(vehicle_name)
        return _kinematics(craft, craft.vehicle.plant.truth, "true")

    def true_pose(self, vehicle_name: str = "") -> Pose:
        """The true pose in the vehicle's local frame."""
        craft = self._find(vehicle_name)
        truth = craft.vehicle.plant.truth
        return Pose(craft.local(truth.position_enu_m), attitude(truth.quat_wxyz))

    def collision(self, vehicle_name: str = "") -> Collision:
        """Return the contacts since the last call."""
        return self._find(vehicle_name).contacts.take()

    def home(self, vehicle_name: str = "") -> GeoPoint:
        """Return the place on the earth where the vehicle started."""
        craft = self._find(vehicle_name)
        return geo(craft.vehicle.frame.geodetic_from_enu(craft.origin_enu_m))

    def environment(self, vehicle_name: str = "") -> Environment:
        """Air and gravity where the vehicle is, by the standard atmosphere."""
        craft = self._find(vehicle_name)
        truth = craft.vehicle.plant.truth
        place = craft.vehicle.frame.geodetic_from_enu(truth.position_enu_m)
        kelvin = 288.15 - 0.0065 * place.altitude_m
        pressure = 101325.0 * (kelvin / 288.15) ** 5.255877
        return Environment(
            position=craft.local(truth.position_enu_m),
            geo_point=geo(place),
            gravity=Vector3r(0.0, 0.0, float(-craft.vehicle.plant.world.model.opt.gravity[2])),
            air_pressure=pressure,
            temperature=kelvin,
            air_density=pressure / (_GAS_CONSTANT * kelvin),
        )

    def rotors(self, vehicle_name: str = "") -> RotorStates:
        """Speed, thrust and torque of each rotor in still air."""
        plant = self._find(vehicle_name).vehicle.plant
        rotors = plant.world.airframe.quadrotor.rotors
        states = []
        for rotor, speed in zip(rotors, plant.rotor_speeds_radps, strict=True):
            thrust = rotor.thrust_constant * speed * abs(speed)
            states.append(Rotor(thrust, thrust * rotor.torque_per_thrust_m, speed))
        return RotorStates(states, stamp(plant.time_us))

    def imu(self, imu_name: str = "", vehicle_name: str = "") -> Imu:
        """Accelerometer and gyroscope, and the estimated attitude."""
        _ = imu_name
        plant = self._find(vehicle_name).vehicle.plant
        reading = plant.sensors.imu
        believed = plant.estimate if plant.is_aligned else plant.truth
        return Imu(
            time_stamp=stamp(reading.time_us),
            orientation=attitude(believed.quat_wxyz),
            angular_velocity=frd(reading.gyro_flu_radps),
            linear_acceleration=frd(reading.accel_flu_mps2),
        )

    def barometer(self, barometer_name: str = "", vehicle_name: str = "") -> Barometer:
        """Pressure and the altitude that the standard atmosphere gives it."""
        _ = barometer_name
        reading = self._find(vehicle_name).vehicle.plant.sensors.baro
        return Barometer(stamp(reading.time_us), reading.altitude_m, reading.pressure_pa)

    def magnetometer(self, magnetometer_name: str = "", vehicle_name: str = "") -> Magnetometer:
        """Field about the vehicle."""
        _ = magnetometer_name
        reading = self._find(vehicle_name).vehicle.plant.sensors.mag
        x, y, z = reading.field_flu_ut
        gauss = (x * _GAUSS_PER_UT, y * _GAUSS_PER_UT, z * _GAUSS_PER_UT)
        return Magnetometer(stamp(reading.time_us), frd(gauss))

    def gps(self, gps_name: str = "", vehicle_name: str = "") -> Gps:
        """The last fix."""
        _ = gps_name
        craft = self._find(vehicle_name)
        reading = craft.vehicle.plant.sensors.gnss
        is_fixed = reading.fix_type >= _FIX_3D
        report = GnssReport(
            geo_point=geo(craft.vehicle.frame.geodetic_from_enu(reading.position_enu_m)),
            eph=reading.eph_m,
            epv=reading.epv_m,
            velocity=ned(reading.velocity_enu_mps),
            fix_type=_FIX_3D if is_fixed else _NO_FIX,
            time_utc=stamp(reading.time_us) // 1000,
        )
        return Gps(stamp(reading.time_us), report, is_fixed)

    def distance(self, distance_sensor_name: str = "", vehicle_name: str = "") -> Distance:
        """Return the measurement of a distance sensor, m."""
        craft = self._find(vehicle_name)
        cfg = named(craft.rangers.distances, distance_sensor_name, "distance sensor")
        return Distance(
            time_stamp=stamp(craft.vehicle.plant.time_us),
            distance=craft.rangers.distance_m(cfg),
            min_distance=cfg.least_m,
            max_distance=cfg.most_m,
            relative_pose=cfg.pose,
        )

    def lidar(self, lidar_name: str = "", vehicle_name: str = "") -> LidarData:
        """Points of a whole turn of a lidar."""
        craft = self._find(vehicle_name)
        cfg = named(craft.rangers.lidars, lidar_name, "lidar")
        points, position, turn = craft.rangers.scan(cfg)
        if cfg.frame != SENSOR_FRAME:
            enu_m = points @ turn.T + np.array(position) - np.array(craft.origin_enu_m)
            points = enu_m @ NED_FROM_ENU.T
        return LidarData(
            time_stamp=stamp(craft.vehicle.plant.time_us),
            point_cloud=floats(points),
            pose=Pose(craft.local(position), quaternion_ned(turn)),
        )

    def sees_point(self, point: GeoPoint, vehicle_name: str = "") -> bool:
        """Return True if nothing is between the vehicle and a place on the earth."""
        craft = self._find(vehicle_name)
        return self._see(craft, craft.vehicle.plant.truth.position_enu_m, _place(craft, point))

    def see_each_other(self, point1: GeoPoint, point2: GeoPoint, vehicle_name: str = "") -> bool:
        """Return True if nothing is between two places on the earth."""
        craft = self._find(vehicle_name)
        return self._see(craft, _place(craft, point1), _place(craft, point2))

    def _see(self, craft: Craft, start: Vector3, end: Vector3) -> bool:
        distance_m = math.dist(start, end)
        if distance_m == 0.0:
            return True
        direction = (np.array(end) - np.array(start)) / distance_m
        return bool(craft.rangers.cast(np.array(start), direction[None, :])[0] >= distance_m)


def _place(craft: Craft, point: GeoPoint) -> Vector3:
    """A place on the earth in the scene.

    Raises:
        RpcError: If it is none.
    """
    latitude, longitude, altitude = point.latitude, point.longitude, point.altitude
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0 and abs(altitude) <= 1e6):
        raise RpcError("point is no place on the earth; valid: degrees, and metres above the sea")
    return craft.vehicle.frame.enu_from_geodetic(Geodetic(latitude, longitude, altitude))


def _kinematics(craft: Craft, state: State, whose: str) -> Kinematics:
    plant = craft.vehicle.plant
    acceleration = _rate_of(plant, f"velocity_{whose}_enu_mps")
    return Kinematics(
        position=craft.local(state.position_enu_m),
        orientation=attitude(state.quat_wxyz),
        linear_velocity=ned(state.velocity_enu_mps),
        angular_velocity=frd(state.angular_rate_flu_radps),
        linear_acceleration=ned(acceleration),
        angular_acceleration=frd(_rate_of(plant, f"angular_rate_{whose}_flu_radps")),
    )


def _rate_of(plant: Plant, name: str) -> Vector3:
    """Rate of change of a logged vector over the last control ticks."""
    rows = plant.history
    span_s = 1e-6 * float(rows["time_us"][-1] - rows["time_us"][0])
    if not span_s > 0.0:
        return (0.0, 0.0, 0.0)
    rate = (rows[name][-1] - rows[name][0]) / span_s
    return vector3(np.where(np.isfinite(rate), rate, 0.0))
