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
"""A rotor within this of the nose lies ahead."""
_N_OF_QUADROTOR = 4


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
    """A camera fixed to the body: RGB-D, or of depth alone."""

    name: str
    position_flu_m: Vector3
    pitch_down_rad: float
    """Pitch: 0 looks along body x, pi/2 straight down with the image's top towards body x."""
    vertical_fov_rad: float
    yaw_rad: float = 0.0
    """Turn of the view about body z, before which it is pitched: pi/2 looks to the left."""
    has_colour: bool = True
    """Without colours it serves the pilot alone: it is neither recorded nor filmed."""

    @property
    def rotation_flu_from_optical(self) -> Float[np.ndarray, "3 3"]:
        """Camera axes (x right, y down, z forward) in the body frame, as columns."""
        sin, cos = math.sin(self.pitch_down_rad), math.cos(self.pitch_down_rad)
        pitched = np.array([[0.0, -sin, cos], [-1.0, 0.0, 0.0], [0.0, -cos, -sin]])
        sin, cos = math.sin(self.yaw_rad), math.cos(self.yaw_rad)
        return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ pitched


@dataclass(frozen=True, kw_only=True, slots=True)
class BodyMesh:
    """A mesh of the whole body but its rotors, in the body frame; it has looks and no contacts."""

    path: str
    """STL or OBJ file."""
    scale: float = 1.0
    """Metres in a unit of the file."""
    position_flu_m: Vector3 = (0.0, 0.0, 0.0)
    """Where the origin of the file lies."""


@dataclass(frozen=True, kw_only=True, slots=True)
class BodyModel:
    """A URDF or MJCF file of the whole body but its rotors, in the body frame."""

    path: str
    """URDF or MJCF file."""
    position_flu_m: Vector3 = (0.0, 0.0, 0.0)
    """Where the origin of the file lies."""
    hits_things: bool = False
    """Whether its solid parts hit things instead of the fuselage; they are looked at anyway."""


class AirframeError(ValueError):
    """No such airframe, or one that cannot be flown; one line says what would be valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Airframe:
    """A vehicle that can be built into a world and flown.

    The body origin is the centre of mass. A leg stands under each arm, unless `feet_flu_m` says
    where the legs stand.
    """

    name: str
    title: str
    drone_class: Literal["small", "medium", "large"]
    quadrotor: QuadrotorParams
    body_size_m: Vector3
    """Collision box of the fuselage: length, width, height."""
    rotor_radius_m: float
    rotor_inertia_kgm2: float
    """Moment of inertia of a rotor with its motor's bell about its axis: how long it coasts."""
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
    """Where legs stand that are not under the arms."""
    has_skids: bool = False
    """Whether a tube joins the first two of four feet, and another one the last two."""
    rotor_imbalance_kgm: float = 1.2e-6
    """Mass times its distance from the axis: how hard a rotor shakes."""
    rotor_friction_nm: float = 2e-3
    """Torque of bearings and cogging, which stops a rotor that coasts."""
    arm_radius_m: float = 0.010
    leg_radius_m: float = 0.009
    motor_radius_m: float = 0.018
    mesh: BodyMesh | None = None
    """What it looks like instead of a fuselage of simple shapes."""
    model: BodyModel | None = None
    """The same from a file that has its own shapes and may be what hits things; not both."""
    handle: str = ""
    """What `--vehicle` takes to name it, where that is not its name: the path of its file."""

    @property
    def rgbd_cameras(self) -> tuple[CameraMount, ...]:
        """Cameras with colours: what is recorded, filmed and shown."""
        return tuple(mount for mount in self.cameras if mount.has_colour)

    @property
    def vehicle(self) -> str:
        """What `--vehicle` takes to name it."""
        return self.handle or self.name

    @property
    def soles_flu_m(self) -> tuple[Vector3, ...]:
        """Contact points of the legs on level ground, in the body frame."""
        if self.feet_flu_m:
            return tuple((x, y, -self.leg_length_m) for x, y in self.feet_flu_m)
        soles = []
        for rotor in self.quadrotor.rotors:
            x, y, _ = rotor.position_flu_m
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

        Of four those are front right, rear left, front left and rear right; with arms along the
        axes right, left, front and rear. More than four are numbered as they are listed.
        """
        if len(self.quadrotor.rotors) != _N_OF_QUADROTOR:
            return tuple(range(len(self.quadrotor.rotors)))
        first, second, third, fourth = self.rotors_clockwise
        if self._bearing_deg(first) < _AHEAD_DEG:
            return (second, fourth, first, third)
        return (first, third, fourth, second)

    def _bearing_deg(self, rotor: int) -> float:
        """Direction of a rotor clockwise from the nose; a little left of it is negative."""
        x, y, _ = self.quadrotor.rotors[rotor].position_flu_m
        return (math.degrees(math.atan2(-y, x)) + _AHEAD_DEG) % 360.0 - _AHEAD_DEG
