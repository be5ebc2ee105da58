"""Airframe: dynamics, extents, battery and cameras of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autonomy.model import QuadrotorParams
from autonomy.types import Vector3


@dataclass(frozen=True, kw_only=True, slots=True)
class BatteryParams:
    """A lithium-polymer pack behind four motors."""

    cells: int
    capacity_mah: float
    internal_resistance_ohm: float
    hover_power_w: float
    """Electrical power of the four motors in hover; it scales with the sum of cubed speeds."""
    hover_rotor_speed_radps: float
    """Speed of each rotor in hover."""
    avionics_power_w: float
    """Electrical power independent of the rotors."""


@dataclass(frozen=True, kw_only=True, slots=True)
class CameraMount:
    """An RGB-D camera fixed to the body."""

    name: str
    position_flu_m: Vector3
    pitch_down_rad: float
    """Pitch: 0 looks along body x, pi/2 straight down with the image's top towards body x."""
    vertical_fov_rad: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Airframe:
    """A vehicle that can be built into a world and flown.

    The body origin is the centre of mass. Four legs stand under the four arms.
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
    """Horizontal distance of each sole from the centre of mass, along its arm."""
    collision_radius_m: float
    """Radius of the upright cylinder around the centre of mass that contains every part."""
    battery: BatteryParams
    cameras: tuple[CameraMount, ...]
