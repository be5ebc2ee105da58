"""Rotors and air: from speed commands to the wrench on the body, once per physics step.

    symbol   name                                                unit
    w        rotor speed, negative backwards                     rad/s
    v        hub velocity relative to the air, FLU               m/s
    v_perp   its part across the rotor's axis, and v_z along it  m/s
    v_i      induced velocity, v_h in hover, kappa w             m/s
    q        (pitch of the blades) - kappa                       m/rad
    u        v_z / (3/4 R): speed along the axis as a rotation   rad/s

    thrust           kf sqrt(w^2 + u^2) (w - (v_z + v_i - v_h) / q) along the rotor's axis
    drag             -|w| k_drag v_perp, at the hub
    reaction torque  -spin c thrust about the axis
    rolling moment   -|w| k_roll v_perp
    lag              first order on w, faster up than down
    coasting         J w' = -kappa thrust - kf (c - kappa) w |w| -+ friction, without power

Thrust is that of a blade of constant pitch whose normal force is proportional to its angle of
attack: kf w^2 in hover, 1 - v_z / 25 m/s of it in slow climb (PX4's axial limit gives q), nothing
where the air meets no pitch, and about that of a flat plate on blades that stand still. Without
power, the part of the torque that hover spends on induced velocity, kappa thrust, turns the rotor;
the rest is profile drag. Ground and ceiling change thrust and v_i.

Sources: Furrer et al. 2016 (RotorS) for drag, moments and lag; PX4's gazebo-classic motor model for
the axial limit; Leishman 2006, chapters 2 and 3, for blade element and momentum theory.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation import DragModel
from autonomy.jit import fields, kernel
from autonomy.model.quadrotor import MAX_ROTORS
from autonomy.rotation import matrix_from_quat
from flightsim.environment.atmosphere import AIR_DENSITY_KGPM3
from flightsim.environment.effects import ALL_EFFECTS, Effects
from flightsim.vehicles.air.frame import frame_drag
from flightsim.vehicles.air.inflow import induced_ratio
from flightsim.vehicles.airframe import Airframe

_COEFFICIENTS = (
    *("thrust_constant", "torque_per_thrust_m", "drag_coefficient"),
    *("rolling_moment_coefficient", "max_speed_radps"),
)
"""Fields of `RotorParams` that the record has too."""

_REPRESENTATIVE_RADIUS = 0.75  # of the radius: the blade element that stands for the whole blade

ROTORS_DTYPE = np.dtype(
    [
        ("n_rotors", "i8"),
        ("effectiveness", "f8", MAX_ROTORS),  # 1 sound, 0 without a blade
        ("command_share", "f8", MAX_ROTORS),  # of its command at which a motor turns: 0 failed
        ("stuck_radps", "f8", MAX_ROTORS),  # speed of a motor that is stuck, 0 of any other
        *fields("share_up", "share_down", shape=(MAX_ROTORS,)),  # of the way in one step
        *fields("speed_radps", "spin", *_COEFFICIENTS, shape=(MAX_ROTORS,)),
        *fields("has_inflow", "can_coast", kind="i8"),
        ("axial_limit_mps", "f8"),  # of PX4's model
        ("rad_per_m", "f8"),  # 1 / q, of inflow
        ("blade_rad_per_m", "f8"),  # 1 / (3/4 R)
        ("induced_m", "f8", MAX_ROTORS),  # kappa
        *fields("dt_per_inertia", "friction_radps"),  # of a rotor that coasts; a step of friction
        *fields("ground_share", "ceiling_ratio", shape=(MAX_ROTORS,)),  # see flightsim.vehicles.air
        *fields("radius_m", "neighbour_m", "opposite_m"),
        ("frame_drag", "f8", 3),  # rho / 2 CdA, kg/m
        *fields("wind_enu_mps", "air_velocity_flu_mps", shape=(3,)),
        *fields("force_flu_n", "torque_flu_nm", shape=(3,)),
        *fields("position_flu_m", "axis_flu", shape=(MAX_ROTORS, 3)),
        ("R", "f8", (3, 3)),
    ],
    align=True,
)


def new_rotors(
    airframe: Airframe,
    *,
    dt_s: float,
    axial_limit_mps: float = 25.0,
    effects: Effects = ALL_EFFECTS,
) -> np.ndarray:
    """Create rotors at rest, as one record in an array of shape (1,).

    Args:
        airframe: The vehicle.
        dt_s: Length of a physics step.
        axial_limit_mps: Speed of climb, by the loss in slow climb at hover speed, at which a rotor
            has no thrust; infinite for no such loss.
        effects: Effects of the model that are on.
    """
    records = np.zeros(1, ROTORS_DTYPE)
    r = records[0]
    rotors = airframe.quadrotor.rotors
    n = r["n_rotors"] = len(rotors)
    r["effectiveness"] = r["command_share"] = 1.0
    for name in ("position_flu_m", "axis_flu", "spin", *_COEFFICIENTS):
        r[name][:n] = [getattr(rotor, name) for rotor in rotors]
    r["share_up"][:n] = [1.0 - math.exp(-dt_s / rotor.time_constant_up_s) for rotor in rotors]
    r["share_down"][:n] = [1.0 - math.exp(-dt_s / rotor.time_constant_down_s) for rotor in rotors]
    r["axial_limit_mps"] = axial_limit_mps
    r["has_inflow"], r["can_coast"] = effects.inflow, effects.windmilling
    # Half of a slow climb is made up by less induced velocity.
    r["rad_per_m"] = 2.0 * airframe.quadrotor.hover_speed_radps / axial_limit_mps
    r["blade_rad_per_m"] = 1.0 / (_REPRESENTATIVE_RADIUS * airframe.rotor_radius_m)
    disc_m2 = math.pi * airframe.rotor_radius_m**2
    # Momentum theory in hover: v_h = sqrt(T / 2 rho A), and T = kf w^2, so v_h = kappa w.
    r["induced_m"] = np.sqrt(r["thrust_constant"] / (2.0 * AIR_DENSITY_KGPM3 * disc_m2))
    r["dt_per_inertia"] = dt_s / airframe.rotor_inertia_kgm2
    r["friction_radps"] = airframe.rotor_friction_nm * r["dt_per_inertia"]
    r["ceiling_ratio"] = 1.0
    r["radius_m"] = airframe.rotor_radius_m
    r["neighbour_m"], r["opposite_m"] = _hub_distances_m(r["position_flu_m"][:n])
    r["frame_drag"] = frame_drag(airframe, has_arms=effects.frame_drag)
    return records


def drag_model(airframe: Airframe, effects: Effects = ALL_EFFECTS) -> DragModel:
    """Return the parameters of air resistance with which an estimator finds the wind."""
    quadrotor = airframe.quadrotor
    mass = quadrotor.mass_kg
    x, y, _ = (frame_drag(airframe, has_arms=effects.frame_drag) / mass).tolist()
    return DragModel(
        rotor_mps_per_rad=tuple(rotor.drag_coefficient / mass for rotor in quadrotor.rotors),
        fuselage_per_m=(x, y),
        thrust_m=tuple(rotor.thrust_constant / mass for rotor in quadrotor.rotors),
    )


def _hub_distances_m(hubs_flu_m: np.ndarray) -> tuple[float, float]:
    """Mean distance of a rotor's axis to the nearest two axes, and to the farthest one."""
    apart = np.linalg.norm(hubs_flu_m[:, None, :2] - hubs_flu_m[None, :, :2], axis=2)
    # Sorted, so that column 0 is the rotor itself.
    ordered = np.sort(apart, axis=1).mean(axis=0)
    return float(ordered[1:3].mean()), float(ordered[-1])


@kernel
def step_rotors(
    r: np.record,
    command_radps: np.ndarray,
    quat_wxyz: np.ndarray,
    velocity_enu_mps: np.ndarray,
    rate_flu_radps: np.ndarray,
    wrench: np.ndarray,
) -> None:
    """Advance the rotor speeds towards their commands by one step and write the resulting wrench.

    Args:
        r: Record of the rotors, changed.
        command_radps: Speed commands (n,), clipped to the rotors' range; 0 is no power, which
            stops also a motor that is stuck.
        quat_wxyz: True attitude.
        velocity_enu_mps: True velocity of the centre of mass.
        rate_flu_radps: True body rates.
        wrench: Result (6,): force and torque about the centre of mass, both in the world frame.
    """
    R, v = r.R, r.air_velocity_flu_mps
    matrix_from_quat(quat_wxyz, R)
    vx = velocity_enu_mps[0] - r.wind_enu_mps[0]
    vy = velocity_enu_mps[1] - r.wind_enu_mps[1]
    vz = velocity_enu_mps[2] - r.wind_enu_mps[2]
    for i in range(3):
        v[i] = R[0, i] * vx + R[1, i] * vy + R[2, i] * vz
        r.force_flu_n[i] = -r.frame_drag[i] * abs(v[i]) * v[i]
        r.torque_flu_nm[i] = 0.0
    for i in range(r.n_rotors):
        command = command_radps[i]
        if command > 0.0:
            command = command * r.command_share[i] + r.stuck_radps[i]
        # NaN commands no power either: the comparison is false.
        is_coasting = r.can_coast == 1 and not command > 0.0
        if not is_coasting:
            _follow(r, i, command)
        _add_rotor(r, i, rate_flu_radps, is_coasting)
    F, M = r.force_flu_n, r.torque_flu_nm
    for i in range(3):
        wrench[i] = R[i, 0] * F[0] + R[i, 1] * F[1] + R[i, 2] * F[2]
        wrench[3 + i] = R[i, 0] * M[0] + R[i, 1] * M[1] + R[i, 2] * M[2]


@kernel
def _follow(r: np.record, i: int, command_radps: float) -> None:
    """Apply a first-order lag, exact for a command that is constant over the step."""
    command = min(max(command_radps, 0.0), r.max_speed_radps[i])
    if not math.isfinite(command_radps):
        command = 0.0
    change = command - r.speed_radps[i]
    r.speed_radps[i] += change * (r.share_up[i] if change >= 0.0 else r.share_down[i])


@kernel
def _add_rotor(r: np.record, i: int, rate: np.ndarray, is_coasting: bool) -> None:
    """Add a rotor's force and torque to those of the body."""
    w, v, hub = r.speed_radps[i], r.air_velocity_flu_mps, r.position_flu_m[i]
    vx = v[0] + rate[1] * hub[2] - rate[2] * hub[1]
    vy = v[1] + rate[2] * hub[0] - rate[0] * hub[2]
    vz = v[2] + rate[0] * hub[1] - rate[1] * hub[0]
    # Only the part along the axis changes the thrust; the rest is drag.
    axis = r.axis_flu[i]
    along = vx * axis[0] + vy * axis[1] + vz * axis[2]
    vx -= along * axis[0]
    vy -= along * axis[1]
    vz -= along * axis[2]
    thrust = _thrust(r, i, along, vx * vx + vy * vy + vz * vz) * r.effectiveness[i]
    torque = 0.0
    if is_coasting:
        _coast(r, i, thrust)
    else:
        torque = r.spin[i] * r.torque_per_thrust_m[i] * thrust
    drag = -abs(w) * r.drag_coefficient[i]
    fx = drag * vx + thrust * axis[0]
    fy = drag * vy + thrust * axis[1]
    fz = drag * vz + thrust * axis[2]
    # Without power nothing but friction reacts on the body, which is left out.
    roll = -abs(w) * r.rolling_moment_coefficient[i]
    F, M = r.force_flu_n, r.torque_flu_nm
    F[0] += fx
    F[1] += fy
    F[2] += fz
    M[0] += hub[1] * fz - hub[2] * fy + roll * vx - torque * axis[0]
    M[1] += hub[2] * fx - hub[0] * fz + roll * vy - torque * axis[1]
    M[2] += hub[0] * fy - hub[1] * fx + roll * vz - torque * axis[2]


@kernel
def _thrust(r: np.record, i: int, vz: float, square_across: float) -> float:
    """Thrust of a sound rotor at its hub's velocity along, and squared across, its axis, N."""
    w = r.speed_radps[i]
    if r.has_inflow == 0:
        loss = min(max(1.0 - abs(vz) / r.axial_limit_mps, 0.0), 1.0)
        return r.thrust_constant[i] * w * w * loss / (1.0 - r.ground_share[i])
    hover = r.induced_m[i] * w
    through, share = vz, r.ground_share[i]
    # A rotor that hardly turns has no wake: the ratio would divide by almost nothing.
    if w > 1.0:
        square_y = square_across / (hover * hover)
        ratio = r.ceiling_ratio[i] * induced_ratio(vz / hover, square_y)
        through += hover * (ratio - 1.0)
        share /= 1.0 + square_y
    u = r.blade_rad_per_m * vz
    thrust = r.thrust_constant[i] * math.sqrt(w * w + u * u) * (w - r.rad_per_m * through)
    return thrust / (1.0 - share)


@kernel
def _coast(r: np.record, i: int, thrust: float) -> None:
    """Let the air and friction turn a rotor without power for a step."""
    w = r.speed_radps[i]
    kappa = min(r.induced_m[i], r.torque_per_thrust_m[i])
    profile = r.thrust_constant[i] * (r.torque_per_thrust_m[i] - kappa)
    w -= r.dt_per_inertia * (kappa * thrust + profile * w * abs(w))
    # Friction slows a rotor down to rest, never beyond.
    slower = max(abs(w) - r.friction_radps, 0.0)
    r.speed_radps[i] = math.copysign(slower, w)
