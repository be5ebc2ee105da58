"""Airframe: dynamics, extents, battery and cameras of a vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from autonomy.model import QuadrotorParams
from autonomy.types import Vector3

_AHEAD_DEG = 10.0
"""Angle from the nose within which a rotor counts as lying ahead."""
_N_OF_QUADROTOR = 4  # the numbering of motors is defined for four


@dataclass(frozen=True, kw_only=True, slots=True)
class BatteryParams:
    """A lithium-polymer pack behind the motors."""

    cells: int
    capacity_mah: float
    internal_resistance_ohm: float
    hover_power_w: float
    """Electrical power of all motors in hover; it scales with the sum of cubed speeds."""
    hover_rotor_speed_radps: float
    """Speed of each rotor in hover."""
    avionics_power_w: float
    """Electrical power independent of the rotors."""
    n_rotors: int = 4


@dataclass(frozen=True, kw_only=True, slots=True)
class CameraMount:
    """A camera fixed to the body: RGB-D, or depth alone."""

    name: str
    position_flu_m: Vector3
    pitch_down_rad: float
    """Pitch: 0 looks along body x, pi/2 straight down with the image's top towards body x."""
    vertical_fov_rad: float
    yaw_rad: float = 0.0
    """Turn of the view about body z, applied after the pitch: pi/2 looks to the left."""
    has_colour: bool = True
    """False makes it serve the pilot alone: it is neither recorded nor filmed."""

    @property
    def rotation_flu_from_optical(self) -> Float[np.ndarray, "3 3"]:
        """Camera axes (x right, y down, z forward) in the body frame, as columns."""
        sin, cos = math.sin(self.pitch_down_rad), math.cos(self.pitch_down_rad)
        # Columns without a turn: right is -y, down and forward are pitched about it.
        pitched = np.array([[0.0, -sin, cos], [-1.0, 0.0, 0.0], [0.0, -cos, -sin]])
        sin, cos = math.sin(self.yaw_rad), math.cos(self.yaw_rad)
        return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ pitched


@dataclass(frozen=True, kw_only=True, slots=True)
class BodyMesh:
    """A mesh of the whole body but its rotors, in the body frame; it has looks and no contacts."""

    path: str
    """STL or OBJ file."""
    scale: float = 1.0
    """Size of the file's unit in metres."""
    position_flu_m: Vector3 = (0.0, 0.0, 0.0)
    """Place of the file's origin in the body frame."""


@dataclass(frozen=True, kw_only=True, slots=True)
class BodyModel:
    """A URDF or MJCF file of the whole body but its rotors, in the body frame."""

    path: str
    """URDF or MJCF file."""
    position_flu_m: Vector3 = (0.0, 0.0, 0.0)
    """Place of the file's origin in the body frame."""
    hits_things: bool = False
    """True lets its solid parts touch obstacles instead of the fuselage; all parts are visible
    anyway."""


class AirframeError(ValueError):
    """There is no such airframe, or it cannot be flown; one line names the valid choices."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Airframe:
    """A vehicle that can be built into a world and flown.

    The body origin is the centre of mass. A leg stands under each arm, unless `feet_flu_m` places
    the legs elsewhere.
    """

    name: str
    title: str
    drone_class: Literal["small", "medium", "large"]
    quadrotor: QuadrotorParams
    body_size_m: Vector3
    """Collision box of the fuselage: length, width, height."""
    rotor_radius_m: float
    rotor_inertia_kgm2: float
    """Moment of inertia of a rotor with its motor's bell about its axis; it sets how long it
    coasts."""
    leg_length_m: float
    """Distance from the centre of mass down to the soles: resting height of the body origin."""
    leg_spread_m: float
    """Greatest horizontal distance of a sole from the centre of mass; along its arm, if it stands
    under one."""
    collision_radius_m: float
    """Radius of the upright cylinder around the centre of mass that contains every part."""
    battery: BatteryParams
    cameras: tuple[CameraMount, ...]
    feet_flu_m: tuple[tuple[float, float], ...] = ()
    """Feet (x, y) of legs that are not under the arms; empty for legs under the arms."""
    has_skids: bool = False
    """True if a tube joins the first two of four feet, and another one the last two."""
    rotor_imbalance_kgm: float = 1.2e-6
    """Mass times its distance from the axis; it sets how hard a rotor shakes."""
    rotor_friction_nm: float = 2e-3
    """Torque of bearings and cogging, which stops a rotor that coasts."""
    arm_radius_m: float = 0.010
    leg_radius_m: float = 0.009
    motor_radius_m: float = 0.018
    mesh: BodyMesh | None = None
    """Mesh that shows the body instead of a fuselage of simple shapes."""
    model: BodyModel | None = None
    """The same from a file that has its own shapes, which may also be what touches obstacles. An
    airframe has a mesh or a model, not both."""
    handle: str = ""
    """Value of `--vehicle` that names it, if that is not its name: the path of its file."""

    @property
    def rgbd_cameras(self) -> tuple[CameraMount, ...]:
        """Cameras with colours: those that are recorded, filmed and shown."""
        return tuple(mount for mount in self.cameras if mount.has_colour)

    @property
    def vehicle(self) -> str:
        """Value of `--vehicle` that names it."""
        return self.handle or self.name

    @property
    def soles_flu_m(self) -> tuple[Vector3, ...]:
        """Contact points of the legs on level ground, in the body frame."""
        if self.feet_flu_m:
            return tuple((x, y, -self.leg_length_m) for x, y in self.feet_flu_m)
        soles = []
        for rotor in self.quadrotor.rotors:
            x, y, _ = rotor.position_flu_m
            # The sole lies on the ray from the centre through the hub.
            scale = self.leg_spread_m / math.hypot(x, y)
            soles.append((x * scale, y * scale, -self.leg_length_m))
        return tuple(soles)

    @property
    def rotors_clockwise(self) -> tuple[int, ...]:
        """Rotors (from 0) clockwise from above, from the nose or from the first one right of it."""
        return tuple(sorted(range(len(self.quadrotor.rotors)), key=self._bearing_deg))

    @property
    def motors(self) -> tuple[int, ...]:
        """Rotors (from 0) of the motors 1, 2, ..., as PX4 and ArduPilot number them.

        Four motors are front right, rear left, front left and rear right; with arms along the axes
        right, left, front and rear. More than four are numbered as they are listed.
        """
        if len(self.quadrotor.rotors) != _N_OF_QUADROTOR:
            return tuple(range(len(self.quadrotor.rotors)))
        first, second, third, fourth = self.rotors_clockwise
        # A rotor ahead means arms along the axes.
        if self._bearing_deg(first) < _AHEAD_DEG:
            return (second, fourth, first, third)
        return (first, third, fourth, second)

    def _bearing_deg(self, rotor: int) -> float:
        """Direction of a rotor clockwise from the nose, deg; a little left of it is negative."""
        x, y, _ = self.quadrotor.rotors[rotor].position_flu_m
        # y is left, so the sign turns the angle clockwise. The offset keeps a rotor that is meant
        # to lie ahead from wrapping to 360 degrees by rounding.
        return (math.degrees(math.atan2(-y, x)) + _AHEAD_DEG) % 360.0 - _AHEAD_DEG
