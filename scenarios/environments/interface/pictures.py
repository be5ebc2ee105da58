"""Pictures of the vehicles in an environment, for people: the result of `render()`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from jaxtyping import Float, UInt8

from autonomy.rotation import yaw_from_quat
from flightsim.cameras import CameraRenderer, open_camera_renderer
from flightsim.cameras.framing import frame_points
from flightsim.plant import Fleet
from scenarios.environments.cfg import EnvironmentInputError
from scenarios.recording.chase import FOV_RAD, ChaseEye

RENDER_MODES: Final = ["rgb_array"]
"""Modes of Gymnasium and PettingZoo; no window is ever opened."""
WIDTH_PX, HEIGHT_PX = 640, 480
_ELEVATION_RAD = math.radians(25.0)
_ROOM_M = 1.0
"""Room about each vehicle of a swarm in its picture."""
Picture = UInt8[np.ndarray, "height width 3"]


def checked_render_mode(mode: str | None) -> str | None:
    """Return the mode if it is valid.

    Raises:
        EnvironmentInputError: If it is not.
    """
    if mode is not None and mode not in RENDER_MODES:
        valid = ", ".join(map(repr, RENDER_MODES))
        raise EnvironmentInputError(f"render_mode = {mode!r}: None and {valid} are valid")
    return mode


class Photographer:
    """Takes pictures of the vehicles of a fleet; a renderer is opened with the first picture.

    It only reads the worlds and changes nothing, so an episode is the same with and without
    pictures.
    """

    def __init__(self, fleet: Fleet, step_s: float) -> None:
        """Prepare for a fleet.

        Args:
            fleet: The vehicles.
            step_s: Time between two pictures, by which the eye follows.
        """
        self._fleet = fleet
        self._step_s = step_s
        self._renderers: dict[int, CameraRenderer] = {}
        self._eyes: dict[int, ChaseEye] = {}

    def begin(self, index: int) -> None:
        """Stand behind a vehicle anew, because its next episode begins elsewhere."""
        self._eyes.pop(index, None)

    def behind(self, index: int) -> Picture:
        """Return a view of a vehicle from behind and above, and never through a wall."""
        position_enu_m, quat_wxyz = self._pose(index)
        # Each vehicle has its own eye, which follows smoothly from picture to picture.
        eye = self._eyes.get(index)
        if eye is None:
            eye = self._eyes[index] = ChaseEye(self._fleet.worlds[index], yaw_from_quat(quat_wxyz))
        velocity_enu_mps = self._fleet.history["velocity_true_enu_mps"][index, -1]
        place = eye.follow(position_enu_m, velocity_enu_mps, self._step_s)
        return self._view(index, place, position_enu_m.tolist())

    def together(self, vehicles: Sequence[int]) -> Picture:
        """Return a view of all vehicles of a world, from the south-west and above."""
        eye, target = frame_points(
            _with_room(np.array([self._pose(i)[0] for i in vehicles])),
            # From the south-west.
            azimuth_rad=math.radians(-135.0),
            elevation_rad=_ELEVATION_RAD,
            vertical_fov_rad=FOV_RAD,
            aspect=WIDTH_PX / HEIGHT_PX,
        )
        return self._view(vehicles[0], eye, target)

    def close(self) -> None:
        """Release the renderers."""
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()

    def _pose(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        """Return position and attitude now; the history has those of the last step only."""
        first = self._fleet.worlds[index].qpos_address
        pose = self._fleet.data(index).qpos[first : first + 7]
        # Copies: the arrays belong to MuJoCo and change with the next step.
        return pose[:3].copy(), pose[3:].copy()

    def _view(self, index: int, eye: Sequence[float], target: Sequence[float]) -> Picture:
        renderer = self._renderers.get(index)
        if renderer is None:
            world = self._fleet.worlds[index]
            renderer = self._renderers[index] = open_camera_renderer(world, WIDTH_PX, HEIGHT_PX)
        (ex, ey, ez), (x, y, z) = eye, target
        return renderer.render_view(self._fleet.data(index), (ex, ey, ez), (x, y, z), FOV_RAD).rgb


def _with_room(points_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3"]:
    offsets = _ROOM_M * np.concatenate([np.eye(3), -np.eye(3)])
    return (points_enu_m[:, None] + offsets).reshape(-1, 3)
