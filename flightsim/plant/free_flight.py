"""Free flight: the kernel integrates a vehicle itself while nothing can touch it.

MuJoCo spends almost all of a step on geoms and contacts, and a vehicle in the air has no contact.
If the clearance around a vehicle proves that, the kernel integrates its free joint by the scheme
that MuJoCo uses, semi-implicit Euler:

    v' = v + h (F / m + g)               F force, ENU
    w' = w + h I^-1 (T - w x I w)        T torque, w body rates, FLU
    p' = p + h v',  q' = q exp(h w' / 2)

Pose, velocity, time and the solver's warm start stay in MuJoCo's memory, so that either of the two
can take the next step. A search of the ray tree returns a sphere in which the vehicle is free.
Until the vehicle leaves that sphere, a step only computes the distance to its centre.

Source of the attitude integration: MuJoCo's `mju_quatIntegrate`.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from aeroscene.neighbourhood import GAP_M
from autonomy.jit import fields, kernel
from flightsim.plant.clearance import clearance_m
from flightsim.plant.mujoco_calls import doubles
from flightsim.world import NEIGHBOUR_ID, World

_MARGIN_M = 0.01
"""Added to a vehicle's reach, so that rounding cannot hide a contact."""
_MOST_CLEARANCE_M = 50.0
"""Obstacles farther away than this are not searched."""
_LEAST_CLEARANCE_M = 0.02
"""Least distance between two searches. With less clearance MuJoCo takes the steps."""
_FARTHEST_M = 1e6
"""Distance from the origin up to which a position is believed. MuJoCo reports states that are
infinite or not a number, so it must get them."""

FREE_FLIGHT_DTYPE = np.dtype(
    [
        ("is_on", "i8"),
        ("n_steps", "i8"),  # steps that the kernel has taken itself
        # addresses of the world's geoms: bounding boxes, contact bits
        *fields("aabb_address", "contype_address", "conaffinity_address", kind="i8"),
        # addresses of the vehicle's accelerations (6,), and of the forces and torques (6,) that
        # come from outside the plant
        *fields("warm_start_address", "push_address", kind="i8"),
        *fields("reach_m", "mass_kg", "dt_s"),
        *fields("inertia_flu_kgm2", "gravity_enu_mps2", shape=(3,)),
        ("centre_enu_m", "f8", 3),  # where the clearance was measured last
        ("clearance_m", "f8"),  # radius of the free sphere; negative: contacts are possible in it
        # Horizontal bounds of the flight volume: what stands around it is not in the rays' tree.
        *fields("low_enu_m", "high_enu_m", shape=(2,)),
    ],
    align=True,
)


def new_free_flight(world: World, data: mujoco.MjData, *, is_on: bool) -> np.ndarray:
    """Return the record of a vehicle whose clearance is not known yet, (1,) of `FREE_FLIGHT_DTYPE`.

    The record holds addresses, so `world` and `data` must outlive it.

    Args:
        world: The world as the vehicle has it.
        data: State of the physics.
        is_on: True lets the kernel take steps itself; otherwise MuJoCo takes all of them.
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
    f["low_enu_m"], f["high_enu_m"] = -np.inf, np.inf
    if np.any(world.geom_object_id == NEIGHBOUR_ID):
        # The neighbourhood begins GAP_M beyond the volume, less 0.5 m of tolerance. Bounds shrink
        # only if the vehicle reaches farther than that.
        spare_m = min(GAP_M - 0.5 - float(f["reach_m"]), 0.0)
        f["low_enu_m"] = np.array(world.scene.extent_min_enu_m[:2]) - spare_m
        f["high_enu_m"] = np.array(world.scene.extent_max_enu_m[:2]) + spare_m
    return records


@kernel
def is_free(plants: np.ndarray) -> bool:
    """Return true if no vehicle of a world can have a contact in its present pose.

    Movers are not considered: `flightsim.environment.motion.let_touch` returns whether one is near.

    Args:
        plants: `PLANT_DTYPE` (v,). If one has left its sphere, the clearance of all is measured
            anew.
    """
    for k in range(len(plants)):
        f = plants[k].free_flight
        if f.is_on == 0:
            return False
        place = doubles(plants[k].engine.qpos_address, 3)
        if not _is_within(f, place):
            return False
        away_m = _apart_m(f.centre_enu_m, place)
        # Written so that a position that is not a number fails the test.
        if not away_m < abs(f.clearance_m):
            return _measure_clearance(plants)
    return _have_clearance(plants)


@kernel
def _is_within(f: np.record, place: np.ndarray) -> bool:
    """Return true if a place lies within the horizontal bounds, if there are any."""
    is_east = f.low_enu_m[0] <= place[0] <= f.high_enu_m[0]
    return is_east and f.low_enu_m[1] <= place[1] <= f.high_enu_m[1]


@kernel
def _measure_clearance(plants: np.ndarray) -> bool:
    """Measure the clearance of all vehicles of a world; return true if each has enough."""
    for k in range(len(plants)):
        e, f = plants[k].engine, plants[k].free_flight
        place = doubles(e.qpos_address, 3)
        for i in range(3):
            f.centre_enu_m[i] = place[i]
        is_here = abs(place[0]) + abs(place[1]) + abs(place[2]) < _FARTHEST_M
        f.clearance_m = (
            clearance_m(e.rays, f, place, _MOST_CLEARANCE_M) - f.reach_m if is_here else 0.0
        )
        for j in range(k):
            g = plants[j].free_flight
            gap_m = _apart_m(f.centre_enu_m, g.centre_enu_m) - f.reach_m - g.reach_m
            # Either may move up to half of the gap, so their spheres never overlap.
            f.clearance_m, g.clearance_m = (
                min(f.clearance_m, 0.5 * gap_m),
                min(g.clearance_m, 0.5 * gap_m),
            )
    for k in range(len(plants)):
        f = plants[k].free_flight
        if not f.clearance_m > _LEAST_CLEARANCE_M:
            # The size of a negative clearance is the distance to the next search, see `is_free`.
            f.clearance_m = min(f.clearance_m, -_LEAST_CLEARANCE_M)
    return _have_clearance(plants)


@kernel
def _have_clearance(plants: np.ndarray) -> bool:
    is_free = True
    for k in range(len(plants)):
        is_free &= plants[k].free_flight.clearance_m > 0.0
    return is_free


@kernel
def step_free(
    f: np.record, r: np.record, force_enu_n: np.ndarray, pose: np.ndarray, velocity: np.ndarray
) -> None:
    """Integrate a vehicle's motion by one physics step.

    Args:
        f: `FREE_FLIGHT_DTYPE`.
        r: Record of the rotors, with the torque on the body in FLU, N m.
        force_enu_n: Force of rotors and air on the centre of mass (3,), N.
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
        # Semi-implicit: the new velocity moves the pose. The order must stay MuJoCo's.
        velocity[k] += f.dt_s * accelerations[k]
    for k in range(3):
        pose[k] += f.dt_s * velocity[k]
    _turn(pose[3:7], velocity[3:6], f.dt_s)


@kernel
def _turn(quat_wxyz: np.ndarray, rate_flu_radps: np.ndarray, dt_s: float) -> None:
    """Integrate an attitude (w, x, y, z) over a step of constant body rates, in place."""
    x, y, z = rate_flu_radps[0], rate_flu_radps[1], rate_flu_radps[2]
    speed = math.sqrt(x * x + y * y + z * z)
    # The axis of rotation is undefined, and the attitude does not change.
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
    """Return the distance from a body's origin beyond which it touches no static geom or vehicle.

    MuJoCo makes a contact of two geoms whose distance is less than the sum of their margins, so
    margins belong to the reach.
    """
    touching = _may_touch(model)
    is_own, stands = touching & (model.geom_bodyid == body), touching & (model.geom_bodyid == 0)
    reaches_m = np.linalg.norm(model.geom_pos[is_own], axis=1) + model.geom_rbound[is_own]
    reaches_m += model.geom_margin[is_own]
    return float(reaches_m.max(initial=0.0) + model.geom_margin[stands].max(initial=0.0))


def _is_plain(world: World) -> bool:
    """Return true if this integration equals MuJoCo's and every geom with contacts is known.

    The ray tree holds all geoms but those around the site, which the bounds keep away. Joints,
    damping, actuators, fluid forces or an offset centre of mass would make a difference.
    """
    model, tree = world.model, world.rays
    bodies = [view.vehicle_body_id for view in world.views]
    n_moving = model.nbody - model.nmocap - 1
    is_free = n_moving == model.njnt == len(bodies) and model.nv == 6 * len(bodies)
    has_forces = model.nu + model.ntendon + model.neq > 0 or model.opt.density > 0.0
    is_damped = bool(model.dof_damping.any() or model.dof_armature.any())
    is_centred = not model.body_ipos[bodies].any() and bool(
        (model.body_iquat[bodies] == (1.0, 0.0, 0.0, 0.0)).all()
    )
    around = np.flatnonzero(world.geom_object_id == NEIGHBOUR_ID)
    known = np.concatenate([tree.leaf_geoms, tree.endless_geoms, tree.moving_geoms, around])
    is_known = bool(np.isin(np.flatnonzero(_may_touch(model)), known).all())
    return is_free and not has_forces and not is_damped and is_centred and is_known


def _may_touch(model: mujoco.MjModel) -> np.ndarray:
    return (model.geom_contype != 0) | (model.geom_conaffinity != 0)
