"""Contacts of a flight: the objects that the vehicle touched, and when.

The plant logs at each control tick whether the vehicle touched something, but not which object,
because that would slow every flight. The object follows afterwards from the pose of that tick in a
copy of the world. Its vehicle feels a centimetre beyond its hull, because a contact may begin and
end within a tick.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Vector3, vector3
from flightsim.looks.movers import MOVER_CONTACT_BIT
from flightsim.vehicles.builder import vehicle_name
from flightsim.world import GROUND_NAME, World
from scenarios.trials.limits import LIMITS

_FELT_M = 0.01  # beyond the hull, in the copy of the world
_IMPACT_S = 0.02
"""Time before a contact in which its speed is measured, because solids are a little soft."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """Touch of one object, from its first to its last moment."""

    time_s: float
    until_s: float
    what: str
    """The object with its number and category, the ground, or the mover."""
    object_id: int | None
    """Number of the object in the scene; None for the ground and for movers."""
    position_enu_m: Vector3
    """First point of contact."""
    category: str | None = None
    """Category of the object; None for the ground and for movers."""
    speed_mps: float = 0.0
    """Speed of the vehicle when the contact began."""

    @property
    def is_with_ground(self) -> bool:
        """True if it is a contact with the bare ground."""
        return self.object_id is None and self.what == GROUND_NAME

    def spans(self, time_s: float) -> bool:
        """Return whether the object is touched at a time."""
        return self.time_s <= time_s <= self.until_s

    def to_plain(self) -> dict[str, Any]:
        """Return the contact as plain data, rounded to a millimetre and a millisecond."""
        x, y, z = (round(c, 3) for c in self.position_enu_m)
        times = {"time_s": round(self.time_s, 3), "until_s": round(self.until_s, 3)}
        speed = {"speed_mps": round(self.speed_mps, 3)}
        return asdict(self) | times | {"position_enu_m": [x, y, z]} | speed


@dataclass(frozen=True, kw_only=True, eq=False)
class MoverPoses:
    """Poses of k movers, as MuJoCo has them, at n times."""

    position_enu_m: Float[np.ndarray, "n k 3"]
    quat_wxyz: Float[np.ndarray, "n k 4"]


class ContactFinder:
    """Finds the objects that a vehicle touched in a world.

    The world is copied once, so that one finder can serve many flights.
    """

    def __init__(self, world: World) -> None:
        """Copy the world, with a vehicle that feels somewhat beyond its hull."""
        self._world = world
        self._category = {thing.id: thing.category for thing in world.scene.objects}
        self._model = model = copy.copy(world.model)
        model.geom_margin[_hull(world)] = _FELT_M
        is_mover = model.body_mocapid >= 0
        # The vehicle must feel movers in this copy.
        model.geom_conaffinity[is_mover[model.geom_bodyid]] = MOVER_CONTACT_BIT
        bodies = [model.body(vehicle_name(k)).id for k in range(world.n_vehicles)]
        self._poses = [model.jnt_qposadr[model.body_jntadr[body]] for body in bodies]
        self._body_of: list[int] = model.geom_bodyid.tolist()
        self._thing_of: list[int] = world.geom_object_id.tolist()
        self._data = mujoco.MjData(model)
        # Bounds and masks of bodies follow from those of their geoms.
        mujoco.mj_setConst(model, self._data)
        mujoco.mj_forward(model, self._data)

    def find(
        self,
        history: np.ndarray,
        movers: MoverPoses,
        counts: Bool[np.ndarray, " n"],
        mates: Sequence[np.ndarray] = (),
    ) -> tuple[Contact, ...]:
        """Return the contacts of a flight in the order of time.

        Args:
            history: Rows of control ticks (`flightsim.plant.record`), n of them.
            movers: Poses of the movers at the same rows.
            counts: True for rows at which contacts count.
            mates: The same rows of the other vehicles, in their order.
        """
        flights = list(mates)
        # MuJoCo has the vehicles in the order of their numbers.
        flights.insert(self._world.number, history)
        poses = [
            (self._data.qpos[at : at + 7], flight["position_true_enu_m"], flight["quat_true_wxyz"])
            for at, flight in zip(self._poses, flights, strict=True)
        ]
        found: list[Contact] = []
        latest: dict[int, int] = {}
        for row in np.flatnonzero(counts & (history["is_touching"] > 0)).tolist():
            time_s = float(history["time_us"][row]) * 1e-6
            self._data.mocap_pos[:] = movers.position_enu_m[row]
            self._data.mocap_quat[:] = movers.quat_wxyz[row]
            for qpos, positions_enu_m, quats_wxyz in poses:
                qpos[:3], qpos[3:] = positions_enu_m[row], quats_wxyz[row]
            for thing, point_enu_m in self._touched().items():
                # One object may be touched again and again; gaps below the limit join contacts.
                last = latest.get(thing)
                if last is not None and time_s - found[last].until_s <= LIMITS.contact_gap_s:
                    found[last] = replace(found[last], until_s=time_s)
                    continue
                latest[thing] = len(found)
                contact = Contact(
                    time_s=time_s,
                    until_s=time_s,
                    what=self._world.name_of(thing),
                    object_id=thing if thing >= 0 else None,
                    position_enu_m=point_enu_m,
                    category=self._category.get(thing),
                    speed_mps=impact_mps(history, row),
                )
                found.append(contact)
        return tuple(found)

    def _touched(self) -> dict[int, Vector3]:
        """Points of contact by the id of the object; the nearest object if none quite touches."""
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        # Plain numbers: there are a few contacts, for which an array takes longer than the physics,
        # and so does an object for each.
        contact, vehicle, body_of = self._data.contact, self._world.vehicle_body_id, self._body_of
        own: list[tuple[float, int, int]] = []
        pairs: list[tuple[int, int]] = contact.geom.tolist()
        for row, ((a, b), dist_m) in enumerate(zip(pairs, contact.dist.tolist(), strict=True)):
            if body_of[a] == vehicle:
                own.append((dist_m, self._thing_of[b], row))
            elif body_of[b] == vehicle:
                own.append((dist_m, self._thing_of[a], row))
        if not own:
            return {}
        # Beyond the hull only if nothing touches the hull itself.
        reach_m = max(min(own)[0], 0.0)
        # The deepest contact of each object comes last, so it is the one that the dictionary keeps.
        own.sort(key=lambda each: -each[0])
        points_enu_m = contact.pos
        return {
            thing: vector3(points_enu_m[row]) for dist_m, thing, row in own if dist_m <= reach_m
        }


def impact_mps(history: np.ndarray, row: int) -> float:
    """Return the greatest speed just before a row of a history, at which a contact begins, m/s."""
    times_us = history["time_us"]
    first = np.searchsorted(times_us, times_us[row] - round(1e6 * _IMPACT_S))
    before = history[first:row]
    return float(np.linalg.norm(before["velocity_true_enu_mps"], axis=1).max(initial=0.0))


def _hull(world: World) -> Bool[np.ndarray, " ngeom"]:
    """Return the geoms of the vehicle that can touch something."""
    model = world.model
    return (model.geom_bodyid == world.vehicle_body_id) & (model.geom_contype > 0)
