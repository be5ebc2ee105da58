"""Messages of AirSim's API, field by field as they are on the wire.

Frames and units are AirSim's: north-east-down or forward-right-down, metres, radians, and
quaternions w x y z from body to world.
"""

from __future__ import annotations

import math

import msgspec


class Vector3r(msgspec.Struct, frozen=True):
    """A vector."""

    x_val: float = 0.0
    y_val: float = 0.0
    z_val: float = 0.0

    @property
    def is_finite(self) -> bool:
        """Return True if all components are finite."""
        return all(map(math.isfinite, (self.x_val, self.y_val, self.z_val)))


class Quaternionr(msgspec.Struct, frozen=True):
    """An attitude."""

    w_val: float = 1.0
    x_val: float = 0.0
    y_val: float = 0.0
    z_val: float = 0.0


class Pose(msgspec.Struct, frozen=True):
    """Position and attitude."""

    position: Vector3r = Vector3r()
    orientation: Quaternionr = Quaternionr()


class GeoPoint(msgspec.Struct, frozen=True):
    """Place on the earth: degrees, and metres above mean sea level."""

    latitude: float = 0.0
    longitude: float = 0.0
    altitude: float = 0.0


class YawMode(msgspec.Struct, frozen=True):
    """A rate in degrees/s or a heading in degrees, clockwise from north."""

    is_rate: bool = True
    yaw_or_rate: float = 0.0


class ImageRequest(msgspec.Struct, frozen=True):
    """A picture that is wanted."""

    camera_name: str
    image_type: int
    pixels_as_float: bool = False
    compress: bool = True
    annotation_name: str = ""


class ImageResponse(msgspec.Struct, frozen=True, kw_only=True):
    """A picture."""

    image_data_uint8: bytes = b""
    image_data_float: msgspec.Raw
    camera_position: Vector3r
    camera_name: str
    camera_orientation: Quaternionr
    time_stamp: int
    message: str = ""
    pixels_as_float: bool
    compress: bool
    width: int
    height: int
    image_type: int
    annotation_name: str = ""


class Kinematics(msgspec.Struct, frozen=True, kw_only=True):
    """Motion: rates and accelerations of rotation about the body's axes, the rest in the world."""

    position: Vector3r
    orientation: Quaternionr
    linear_velocity: Vector3r
    angular_velocity: Vector3r
    linear_acceleration: Vector3r
    angular_acceleration: Vector3r = Vector3r()


class Collision(msgspec.Struct, frozen=True, kw_only=True):
    """The last thing that the vehicle touched."""

    has_collided: bool = False
    penetration_depth: float = 0.0
    time_stamp: int = 0
    normal: Vector3r = Vector3r()
    impact_point: Vector3r = Vector3r()
    position: Vector3r = Vector3r()
    object_name: str = ""
    object_id: int = -1


class RCData(msgspec.Struct, frozen=True):
    """Sticks of a radio: throttle 0 to 1, the others -1 to 1, positive to the right and ahead."""

    timestamp: int = 0
    pitch: float = 0.0
    roll: float = 0.0
    throttle: float = 0.0
    yaw: float = 0.0
    left_z: float = 0.0
    right_z: float = 0.0
    switches: int = 0
    vendor_id: str = ""
    is_initialized: bool = False
    is_valid: bool = False


class MultirotorState(msgspec.Struct, frozen=True, kw_only=True):
    """State of a vehicle."""

    collision: Collision
    kinematics_estimated: Kinematics
    gps_location: GeoPoint
    timestamp: int
    landed_state: int
    rc_data: RCData = RCData()
    ready: bool
    ready_message: str
    can_arm: bool


class Rotor(msgspec.Struct, frozen=True):
    """A rotor: thrust in N, torque in N m, speed in rad/s."""

    thrust: float
    torque_scaler: float
    speed: float


class RotorStates(msgspec.Struct, frozen=True):
    """All rotors of a vehicle."""

    rotors: list[Rotor]
    timestamp: int


class Environment(msgspec.Struct, frozen=True, kw_only=True):
    """Air and gravity where a vehicle is: Pa, kelvin, kg/m^3."""

    position: Vector3r
    geo_point: GeoPoint
    gravity: Vector3r
    air_pressure: float
    temperature: float
    air_density: float


class Imu(msgspec.Struct, frozen=True, kw_only=True):
    """Attitude, angular rate and specific force in body axes."""

    time_stamp: int
    orientation: Quaternionr
    angular_velocity: Vector3r
    linear_acceleration: Vector3r


class Barometer(msgspec.Struct, frozen=True):
    """Metres, Pa and hPa."""

    time_stamp: int
    altitude: float
    pressure: float
    qnh: float = 1013.25


class Magnetometer(msgspec.Struct, frozen=True):
    """Field in body axes, in gauss."""

    time_stamp: int
    magnetic_field_body: Vector3r
    magnetic_field_covariance: list[float] = []


class GnssReport(msgspec.Struct, frozen=True, kw_only=True):
    """A fix."""

    geo_point: GeoPoint
    eph: float
    epv: float
    velocity: Vector3r
    fix_type: int
    time_utc: int


class Gps(msgspec.Struct, frozen=True):
    """Report of the satellite receiver."""

    time_stamp: int
    gnss: GnssReport
    is_valid: bool


class Distance(msgspec.Struct, frozen=True, kw_only=True):
    """Measurement of a rangefinder."""

    time_stamp: int
    distance: float
    min_distance: float
    max_distance: float
    relative_pose: Pose


class LidarData(msgspec.Struct, frozen=True, kw_only=True):
    """Points of one scan: x, y, z of the first, of the second and so on."""

    time_stamp: int
    point_cloud: msgspec.Raw
    groundtruth: list[str] = []
    pose: Pose


class ProjectionMatrix(msgspec.Struct, frozen=True):
    """Rows of a projection, 4 by 4."""

    matrix: list[list[float]]


class CameraInfo(msgspec.Struct, frozen=True):
    """Pose in the vehicle's local frame, horizontal field of view in degrees."""

    pose: Pose
    fov: float
    proj_mat: ProjectionMatrix
