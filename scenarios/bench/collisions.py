"""Random collisions between two vehicles, which show whether either passes through the other.

Fast bodies can pass through each other in a simulation, because contacts are only found at the end
of a physics step. Two vehicles without power therefore fly at each other, from any side, in any
attitude, off each other's middle, at up to 20 m/s. First they fly with contacts switched off, and
their overlap is measured in steps of 8 mm, so that no collision is missed. Then the same flight is
repeated with contacts.

A vehicle passes through the other in one of three cases: one of them feels no contact; their
relative velocity hardly changes; or a part of one comes more than halfway into the fuselage of the
other, from where it would be pushed out on the other side.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from flightsim.vehicles.builder import part_name
from flightsim.vehicles.contact_filter import STATIC_CONTACT_BIT
from flightsim.world import World

LEAST_CHANGE = 0.05
"""Least change of the relative velocity, as a share of the one before, that counts as a hit."""
_SPEED_MPS = (1.0, 20.0)
_RATE_RADPS = 2.0
_HEIGHT_M = 100.0
_SWEEP_M = 0.008
"""Relative path between two measurements of the overlap, without contacts."""
_COUNTS_M = 0.01
"""Overlap from which an encounter counts as a collision; less is a touch of tips."""
_AIM = 0.8
"""Greatest offset of the aim from the other's middle, over the sum of both radii."""
_ROOM_M = 0.25


@dataclass(frozen=True, slots=True)
class Collision:
    """Result of one encounter of two vehicles."""

    speed_mps: float
    """Relative speed before the encounter."""
    undisturbed_m: float
    """Depth to which the hulls would have overlapped without contacts."""
    is_noticed: bool
    """True if both vehicles felt a contact."""
    depth_m: float
    """Depth to which parts of one came into the fuselage of the other."""
    half_m: float
    """Half of the least side of their fuselages."""
    change: float
    """Change of the relative velocity, as a share of the relative speed before."""

    @property
    def passes_through(self) -> bool:
        """True if one passed through the other."""
        goes_on = not self.is_noticed or self.change < LEAST_CHANGE
        return goes_on or self.depth_m > self.half_m


class Collider:
    """Lets the two vehicles of a world collide."""

    def __init__(self, world: World, rng: np.random.Generator) -> None:
        """Take the two vehicles of a world.

        Args:
            world: World with two vehicles and nothing in their way.
            rng: Source of the encounters.
        """
        worlds = world.views
        self._rng = rng
        self._model = world.model
        self._data = mujoco.MjData(self._model)
        # A copy in which nothing has contacts, for the first of the two flights.
        self._untouched = copy.copy(self._model)
        self._untouched.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        self._ghost = mujoco.MjData(self._untouched)
        self._half_m = min(min(world.airframe.body_size_m) for world in worlds) / 2
        self._hulls, self._shown = _hulls_of(worlds)
        names = [part_name(world.number, "fuselage") for world in worlds]
        self._fuselages = [self._model.geom(name).id for name in names]
        self._radius_m = sum(world.airframe.collision_radius_m for world in worlds)
        joints = [self._model.body_jntadr[world.vehicle_body_id] for world in worlds]
        self._qpos = [int(self._model.jnt_qposadr[joint]) for joint in joints]
        self._dofs = [int(self._model.jnt_dofadr[joint]) for joint in joints]

    def collide(self) -> Iterator[Collision]:
        """Yield collisions without end; encounters that would miss are drawn again."""
        while True:
            way, speed_mps = self._draw()
            undisturbed_m = self._sweep(speed_mps)
            if undisturbed_m >= _COUNTS_M:
                yield self._fly(way, speed_mps, undisturbed_m)

    def _draw(self) -> tuple[np.ndarray, float]:
        """Set two vehicles on a course towards each other, and return its direction and speed."""
        rng, data = self._rng, self._data
        mujoco.mj_resetData(self._model, data)
        way = _direction(rng)
        # Perpendicular to the course, in a random direction.
        aside = np.cross(way, _direction(rng))
        aside *= rng.uniform(0.0, _AIM * self._radius_m) / np.linalg.norm(aside)
        speed_mps = rng.uniform(*_SPEED_MPS)
        apart_m = way * (self._radius_m + _ROOM_M) + aside
        # Half of distance and speed for each vehicle, so that their middle stands still.
        for sign, q, v in zip((-0.5, 0.5), self._qpos, self._dofs, strict=True):
            data.qpos[q : q + 3] = sign * apart_m + (0.0, 0.0, _HEIGHT_M)
            quat = rng.normal(size=4)
            data.qpos[q + 3 : q + 7] = quat / np.linalg.norm(quat)
            data.qvel[v : v + 3] = -sign * speed_mps * way
            data.qvel[v + 3 : v + 6] = rng.normal(scale=_RATE_RADPS, size=3)
        # Long enough to meet and to part again.
        self._lasts_s = 2.0 * (self._radius_m + _ROOM_M) / speed_mps
        return way, speed_mps

    def _sweep(self, speed_mps: float) -> float:
        """Return the deepest overlap of the hulls with contacts switched off."""
        model, ghost, deepest_m = self._untouched, self._ghost, 0.0
        mujoco.mj_resetData(model, ghost)
        ghost.qpos[:], ghost.qvel[:] = self._data.qpos, self._data.qvel
        n_looks = math.ceil(speed_mps * model.opt.timestep / _SWEEP_M)
        for _ in range(math.ceil(self._lasts_s / model.opt.timestep)):
            mujoco.mj_step(model, ghost)
            qpos = ghost.qpos.copy()
            # Between two physics steps the motion is continued at a constant velocity.
            for _ in range(n_looks):
                deepest_m = max(deepest_m, self._overlap_m(qpos))
                mujoco.mj_integratePos(model, qpos, ghost.qvel, model.opt.timestep / n_looks)
        return deepest_m

    def _fly(self, way: np.ndarray, speed_mps: float, undisturbed_m: float) -> Collision:
        data, touched, deepest_m = self._data, [False, False], 0.0
        for _ in range(math.ceil(self._lasts_s / self._model.opt.timestep)):
            mujoco.mj_step(self._model, data)
            for k, v in enumerate(self._dofs):
                touched[k] |= bool(data.qfrc_constraint[v : v + 6].any())
            deepest_m = max(deepest_m, self._overlap_m(data.qpos, is_of_fuselages=True))
        # Before the encounter the relative velocity was `speed_mps` along `way`.
        first, second = (data.qvel[v : v + 3] for v in self._dofs)
        change = float(np.linalg.norm(first - second - speed_mps * way)) / speed_mps
        return Collision(speed_mps, undisturbed_m, all(touched), deepest_m, self._half_m, change)

    def _overlap_m(self, qpos: np.ndarray, *, is_of_fuselages: bool = False) -> float:
        """Return the depth of the hulls in each other, or of any part in a fuselage."""
        self._shown.qpos[:] = qpos
        first, second = self._qpos
        # Bounding spheres first, because most measurements are far from any overlap.
        if np.linalg.norm(qpos[first : first + 3] - qpos[second : second + 3]) > self._radius_m:
            return 0.0
        mujoco.mj_kinematics(self._hulls, self._shown)
        mujoco.mj_collision(self._hulls, self._shown)
        contact = self._shown.contact
        counts = np.any(np.isin(contact.geom, self._fuselages), axis=-1) | (not is_of_fuselages)
        return max(0.0, -float(contact.dist[counts].min(initial=0.0)))


def _hulls_of(worlds: Sequence[World]) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return a model in which only the vehicles' hulls collide, and only with each other."""
    model = copy.copy(worlds[0].model)
    bodies = [world.vehicle_body_id for world in worlds]
    is_hull = np.isin(model.geom_bodyid, bodies) & (model.geom_contype & STATIC_CONTACT_BIT > 0)
    model.geom_contype[:] = model.geom_conaffinity[:] = is_hull
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    return model, data


def _direction(rng: np.random.Generator) -> np.ndarray:
    """Return a direction, all equally likely."""
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction)
