"""Poses of the vehicle and of movers at each moment of a film, read from a recording."""

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
from scenarios.pictures.recorded_story import read_airframe, read_scene
from scenarios.pictures.story import PictureError
from scenarios.recording import layout
from scenarios.recording.rows import RecordedRows
from scenarios.recording.summary import facts_of, readable

_WANTED = (layout.VEHICLE, layout.TRAFFIC, layout.PHASE, layout.SCENE_DOCUMENT)
_BEFORE_S = 1.5
"""Time of the film before the vehicle begins to move, and after it has come to rest."""
_MOVED_M = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Poses:
    """Poses of the vehicle or of one mover, in order of time."""

    time_us: Int[np.ndarray, " n"]
    position_enu_m: Float[np.ndarray, "n 3"]
    quat_wxyz: Float[np.ndarray, "n 4"]

    def at(self, time_us: int) -> int:
        """Return the last row at or before a time, or the first row if all are later."""
        return max(0, int(np.searchsorted(self.time_us, time_us, side="right")) - 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """Moment of one picture of the film, with the state of the world."""

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
        """Read a recording and build its world.

        Args:
            path: File of a recorded flight.

        Raises:
            UnreadableRecordingError: If it is missing or no recording.
            PictureError: If it holds no scene or no flight.
        """
        with readable(path) as source:
            rows = RecordedRows(source, _WANTED)
        run = rows.properties.get(layout.RUN_PROPERTY, {})
        bench = facts_of(run, "config", path).get("bench", {})
        # The same traffic from the same seed has the same shapes; poses come from the recording.
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
        """Return the times of the pictures, from shortly before the flight to shortly after.

        Args:
            step_s: Time from one picture to the next.
        """
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
        """Yield the moments of a film.

        All moments share one `data`, so use each before you take the next.

        Args:
            step_s: Time from one picture to the next.
        """
        data, vehicle = self.world.new_data(), self._vehicle
        for time_us in self.times_us(step_s).tolist():
            row = vehicle.at(time_us)
            before = max(0, row - 1)
            # At least a microsecond, because the first row has no row before it.
            since_s = max(1, int(vehicle.time_us[row] - vehicle.time_us[before])) * 1e-6
            data.qpos[:3], data.qpos[3:7] = vehicle.position_enu_m[row], vehicle.quat_wxyz[row]
            for mover, poses in enumerate(self._movers):
                if len(poses.time_us):
                    seen = poses.at(time_us)
                    data.mocap_pos[mover] = poses.position_enu_m[seen]
                    data.mocap_quat[mover] = poses.quat_wxyz[seen]
            # Renderers and the chase eye need positions of bodies, not of joints.
            mujoco.mj_forward(self.world.model, data)
            moved_m = vehicle.position_enu_m[row] - vehicle.position_enu_m[before]
            # Each phase holds until the next one, so the last that has begun counts.
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
    # A truncated file may lack the last rows of one of the two.
    n = min(len(position_enu_m), len(quat_xyzw))
    return Poses(
        time_us=time_us[:n],
        position_enu_m=position_enu_m[:n].astype(float),
        quat_wxyz=np.roll(quat_xyzw[:n].astype(float), 1, axis=1),
    )
