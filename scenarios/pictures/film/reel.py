"""Poses of vehicle and movers at each moment of a film, read from a recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from jaxtyping import Float, Int

from flightsim.environment.movers import mover_name
from flightsim.environment.traffic import TrafficCfg
from flightsim.world import World, build_world
from scenarios.pictures.recorded import read_airframe, read_scene
from scenarios.pictures.story import PictureError
from scenarios.recording import layout
from scenarios.recording.rows import RecordedRows
from scenarios.recording.summary import facts_of, readable

_WANTED = (layout.VEHICLE, layout.TRAFFIC, layout.PHASE, layout.SCENE_DOCUMENT)
_BEFORE_S = 1.5
"""Time from the beginning of a film to the vehicle's motion, and from its rest to the end."""
_MOVED_M = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Poses:
    """Poses of one thing, in order of time."""

    time_us: Int[np.ndarray, " n"]
    position_enu_m: Float[np.ndarray, "n 3"]
    quat_wxyz: Float[np.ndarray, "n 4"]

    def at(self, time_us: int) -> int:
        """The last row at or before a time."""
        return max(0, int(np.searchsorted(self.time_us, time_us, side="right")) - 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """One picture of the film: the world is as it was then."""

    time_s: float
    phase: str
    """Phase of our pilot; empty for other pilots."""
    data: mujoco.MjData
    position_enu_m: Float[np.ndarray, " 3"]
    velocity_enu_mps: Float[np.ndarray, " 3"]


class Reel:
    """A recorded flight, whose world can be rendered again.

    Attributes:
        world: World of the flight.
    """

    def __init__(self, path: Path) -> None:
        """Read a recording.

        Raises:
            UnreadableRecordingError: If it is missing or no recording.
            PictureError: If it holds no scene or no flight.
        """
        with readable(path) as source:
            rows = RecordedRows(source, _WANTED)
        run = rows.properties.get(layout.RUN_PROPERTY, {})
        bench = facts_of(run, "config", path).get("bench", {})
        traffic = TrafficCfg.parse(bench.get("traffic", "none"), run.get("seed", 0))
        self.world: World = build_world(
            read_scene(rows, path), read_airframe(rows, path), traffic=traffic
        )
        self._vehicle = _poses(rows, layout.VEHICLE)
        if len(self._vehicle.time_us) < 2:
            raise PictureError(f"recording {str(path)!r} holds no flight; valid: one that flew")
        obstacles = self.world.obstacles
        names = [layout.mover(mover_name(i, obstacles)) for i in range(len(obstacles))]
        self._movers = [_poses(rows, name) for name in names]
        self._phases = [(t, row[0]) for t, row in rows.rows(layout.PHASE, "StateChange:state")]

    def times_us(self, step_s: float) -> Int[np.ndarray, " n"]:
        """Times of the pictures, from shortly before the flight to shortly after."""
        vehicle = self._vehicle
        away_m = [
            np.linalg.norm(vehicle.position_enu_m - vehicle.position_enu_m[end], axis=1)
            for end in (0, -1)
        ]
        first, last = np.argmax(away_m[0] > _MOVED_M), np.flatnonzero(away_m[1] > _MOVED_M)
        begin_us = int(vehicle.time_us[first] - 1e6 * _BEFORE_S)
        end_us = int(vehicle.time_us[last[-1] if len(last) else 0] + 1e6 * _BEFORE_S)
        low_us, high_us = int(vehicle.time_us[0]), int(vehicle.time_us[-1])
        return np.arange(max(low_us, begin_us), min(high_us, end_us) + 1, round(1e6 * step_s))

    def play(self, step_s: float) -> Iterator[Moment]:
        """The moments of a film; each takes the place of the one before."""
        data, vehicle = self.world.new_data(), self._vehicle
        for time_us in self.times_us(step_s).tolist():
            row = vehicle.at(time_us)
            before = max(0, row - 1)
            since_s = max(1, int(vehicle.time_us[row] - vehicle.time_us[before])) * 1e-6
            data.qpos[:3], data.qpos[3:7] = vehicle.position_enu_m[row], vehicle.quat_wxyz[row]
            for mover, poses in enumerate(self._movers):
                if len(poses.time_us):
                    seen = poses.at(time_us)
                    data.mocap_pos[mover] = poses.position_enu_m[seen]
                    data.mocap_quat[mover] = poses.quat_wxyz[seen]
            mujoco.mj_forward(self.world.model, data)
            moved_m = vehicle.position_enu_m[row] - vehicle.position_enu_m[before]
            phases = [phase for since_us, phase in self._phases if since_us <= time_us]
            yield Moment(
                time_s=time_us * 1e-6,
                phase=phases[-1] if phases else "",
                data=data,
                position_enu_m=vehicle.position_enu_m[row],
                velocity_enu_mps=moved_m / since_s,
            )


def _poses(rows: RecordedRows, entity: str) -> Poses:
    time_us, position_enu_m = rows.vectors(entity, "Transform3D:translation")
    _, quat_xyzw = rows.vectors(entity, "Transform3D:quaternion", width=4)
    n = min(len(position_enu_m), len(quat_xyzw))
    return Poses(
        time_us=time_us[:n],
        position_enu_m=position_enu_m[:n].astype(float),
        quat_wxyz=np.roll(quat_xyzw[:n].astype(float), 1, axis=1),
    )
