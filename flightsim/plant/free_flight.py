"""Free flight: steps that the kernel takes itself, where nothing can touch the vehicle.

MuJoCo's step of a body in the air costs a hundred times what its motion costs: it places geoms,
looks for contacts and solves for none. Where the distance to all that stands proves that there is
no contact, the kernel integrates the free joint by MuJoCo's own scheme, semi-implicit Euler:

    v' = v + h (F / m + g)               F force, ENU
    w' = w + h I^-1 (T - w x I w)        T torque, w body rates, FLU
    p' = p + h v',  q' = q exp(h w' / 2)

Pose, velocity, time and the solver's warm start stay in MuJoCo's memory, so that either may take
the next step. One search of the tree gives a sphere within which the vehicle is free; until it has
left the sphere, a step asks for the distance from its centre only.

Source of the integration of the attitude: MuJoCo's `mju_quatIntegrate`.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from autonomy.jit import fields, kernel
from flightsim.plant.clearance import clear_m
from flightsim.plant.mujoco_calls import doubles
from flightsim.world import World

_MARGIN_M = 0.01
"""By which a vehicle's reach is larger than the farthest point that can touch: for rounding."""
_LONGEST_LOOK_M = 50.0
_LEAST_ROOM_M = 0.02
"""Way between two searches at least; a vehicle with less room takes MuJoCo's steps."""
_FARTHEST_M = 1e6
"""From the origin; beyond, or where the place is no number, MuJoCo has to say so."""

FREE_FLIGHT_DTYPE = np.dtype(
    [
        ("is_on", "i8"),
        ("n_steps", "i8"),  # that were taken so
        # of the world's geoms: boxes around them, what they may touch
        *fields("aabb_address", "contype_address", "conaffinity_address", kind="i8"),
        # of the vehicle: its accelerations (6,), and forces and torques (6,) from outside the plant
        *fields("warm_start_address", "push_address", kind="i8"),
        *fields("reach_m", "mass_kg", "dt_s"),
        *fields("inertia_flu_kgm2", "gravity_enu_mps2", shape=(3,)),
        ("centre_enu_m", "f8", 3),  # of the sphere that is known
        ("room_m", "f8"),  # its radius; negative where something may touch all over it
    ],
    align=True,
)


def new_free_flight(world: World, data: mujoco.MjData, *, is_on: bool) -> np.ndarray:
    """A vehicle that has not looked around yet, (1,) of `FREE_FLIGHT_DTYPE`.

    Args:
        world: The world as the vehicle has it; it must live on.
        data: State of the physics; it must live on.
        is_on: Whether the kernel may take steps itself; without, MuJoCo takes all.
    """
    model, body = world.model, world.vehicle_body_id
    records = np.zeros(1, FREE_FLIGHT_DTYPE)
    f = records[0]
    f["is_on"] = is_on and _is_plain(world)
    dof = model.jnt_dofadr[model.body_jntadr[body]]
    for name, array in (
        ("aabb", model.geom_aabb),
        ("contype", model.geom_contype),
        ("conaffinity", model.geom_conaffinity),
        ("warm_start", data.qacc_warmstart[dof:]),
        ("push", data.qfrc_applied[dof:]),
    ):
        f[f"{name}_address"] = array.ctypes.data
    f["reach_m"] = _reach_m(model, body) + _MARGIN_M
    f["mass_kg"], f["inertia_flu_kgm2"] = model.body_mass[body], model.body_inertia[body]
    f["gravity_enu_mps2"], f["dt_s"] = model.opt.gravity, model.opt.timestep
    return records


@kernel
def is_free(plants: np.ndarray) -> bool:
    """Whether nothing can touch any of the vehicles of a world as they are now.

    Movers are not looked at: `flightsim.environment.motion.let_touch` says which are near.

    Args:
        plants: `PLANT_DTYPE` (v,), whose spheres are renewed where one has left its own.
    """
    for k in range(len(plants)):
        f = plants[k].free_flight
        if f.is_on == 0:
            return False
        away_m = _apart_m(f.centre_enu_m, doubles(plants[k].engine.qpos_address, 3))
        # A place that is no number is nowhere near.
        if not away_m < abs(f.room_m):
            return _look_around(plants)
    return _have_room(plants)


@kernel
def _look_around(plants: np.ndarray) -> bool:
    """Find the room of all vehicles of a world; whether it is enough for each."""
    for k in range(len(plants)):
        e, f = plants[k].engine, plants[k].free_flight
        place = doubles(e.qpos_address, 3)
        for i in range(3):
            f.centre_enu_m[i] = place[i]
        is_here = abs(place[0]) + abs(place[1]) + abs(place[2]) < _FARTHEST_M
        f.room_m = clear_m(e.rays, f, place, _LONGEST_LOOK_M) - f.reach_m if is_here else 0.0
        for j in range(k):
            g = plants[j].free_flight
            gap_m = _apart_m(f.centre_enu_m, g.centre_enu_m) - f.reach_m - g.reach_m
            # Each may go half of the way to the other.
            f.room_m, g.room_m = min(f.room_m, 0.5 * gap_m), min(g.room_m, 0.5 * gap_m)
    for k in range(len(plants)):
        f = plants[k].free_flight
        if not f.room_m > _LEAST_ROOM_M:
            f.room_m = min(f.room_m, -_LEAST_ROOM_M)
    return _have_room(plants)


@kernel
def _have_room(plants: np.ndarray) -> bool:
    is_free = True
    for k in range(len(plants)):
        is_free &= plants[k].free_flight.room_m > 0.0
    return is_free


@kernel
def step_free(
    f: np.record, r: np.record, force_enu_n: np.ndarray, pose: np.ndarray, velocity: np.ndarray
) -> None:
    """Integrate a vehicle's motion by one physics step.

    Args:
        f: `FREE_FLIGHT_DTYPE`.
        r: Record of the rotors, with the torque on the body.
        force_enu_n: Force of rotors and air on the centre of mass (3,).
        pose: Position ENU and attitude wxyz (7,), changed.
        velocity: Velocity ENU and body rates FLU (6,), changed.
    """
    f.n_steps += 1
    accelerations, push = doubles(f.warm_start_address, 6), doubles(f.push_address, 6)
    inertia, torque = f.inertia_flu_kgm2, r.torque_flu_nm
    x, y, z = velocity[3], velocity[4], velocity[5]
    gyroscopic = (
        y * z * (inertia[2] - inertia[1]),
        z * x * (inertia[0] - inertia[2]),
        x * y * (inertia[1] - inertia[0]),
    )
    for k in range(3):
        accelerations[k] = (force_enu_n[k] + push[k]) / f.mass_kg + f.gravity_enu_mps2[k]
        turning = torque[k] + push[3 + k] - gyroscopic[k]
        accelerations[3 + k] = turning / inertia[k]
    for k in range(6):
        velocity[k] += f.dt_s * accelerations[k]
    for k in range(3):
        pose[k] += f.dt_s * velocity[k]
    _turn(pose[3:7], velocity[3:6], f.dt_s)


@kernel
def _turn(quat_wxyz: np.ndarray, rate_flu_radps: np.ndarray, dt_s: float) -> None:
    """Integrate an attitude over a step of constant body rates."""
    x, y, z = rate_flu_radps[0], rate_flu_radps[1], rate_flu_radps[2]
    speed = math.sqrt(x * x + y * y + z * z)
    if speed == 0.0:
        return
    a, b, c, d = quat_wxyz[0], quat_wxyz[1], quat_wxyz[2], quat_wxyz[3]
    length = math.sqrt(a * a + b * b + c * c + d * d)
    w, share = math.cos(0.5 * dt_s * speed) / length, math.sin(0.5 * dt_s * speed) / speed / length
    x, y, z = share * x, share * y, share * z
    quat_wxyz[0] = a * w - b * x - c * y - d * z
    quat_wxyz[1] = a * x + b * w + c * z - d * y
    quat_wxyz[2] = a * y - b * z + c * w + d * x
    quat_wxyz[3] = a * z + b * y - c * x + d * w


@kernel
def _apart_m(first_m: np.ndarray, second_m: np.ndarray) -> float:
    x, y, z = first_m[0] - second_m[0], first_m[1] - second_m[1], first_m[2] - second_m[2]
    return math.sqrt(x * x + y * y + z * z)


def _reach_m(model: mujoco.MjModel, body: int) -> float:
    """Distance from a body's origin within which it may touch what stands, or another body's reach.

    MuJoCo lets two geoms touch where they are nearer than the sum of their margins.
    """
    touching = _may_touch(model)
    is_own, stands = touching & (model.geom_bodyid == body), touching & (model.geom_bodyid == 0)
    reaches_m = np.linalg.norm(model.geom_pos[is_own], axis=1) + model.geom_rbound[is_own]
    reaches_m += model.geom_margin[is_own]
    return float(reaches_m.max(initial=0.0) + model.geom_margin[stands].max(initial=0.0))


def _is_plain(world: World) -> bool:
    """Whether MuJoCo would integrate as we do, and all that can be met is in the rays' tree."""
    model, tree = world.model, world.rays
    bodies = [view.vehicle_body_id for view in world.views]
    n_moving = model.nbody - model.nmocap - 1
    is_free = n_moving == model.njnt == len(bodies) and model.nv == 6 * len(bodies)
    has_forces = model.nu + model.ntendon + model.neq > 0 or model.opt.density > 0.0
    is_damped = bool(model.dof_damping.any() or model.dof_armature.any())
    is_centred = not model.body_ipos[bodies].any() and bool(
        (model.body_iquat[bodies] == (1.0, 0.0, 0.0, 0.0)).all()
    )
    known = np.concatenate([tree.leaf_geoms, tree.endless_geoms, tree.moving_geoms])
    is_known = bool(np.isin(np.flatnonzero(_may_touch(model)), known).all())
    return is_free and not has_forces and not is_damped and is_centred and is_known


def _may_touch(model: mujoco.MjModel) -> np.ndarray:
    return (model.geom_contype != 0) | (model.geom_conaffinity != 0)
