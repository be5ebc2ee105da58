"""Landing as the pilot's camera sees it: search, choice and descent, without flying.

The vehicle is placed along its path every 0.2 s; its camera renders with the errors of a depth
camera; the watch fuses with a pose that has the estimator's errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import Rotation

from aeroscene.scene import InteractionArea
from autonomy.perception import LandingSite
from autonomy.types import Vector3, vector3
from flightsim.cameras import open_camera_renderer
from flightsim.cameras.depth_noise import DepthNoiseCfg, measured_depth
from flightsim.cameras.view import PosedDepth
from flightsim.mavlink.client.telemetry import Telemetry
from flightsim.world import World
from scenarios.mission.surroundings import Surroundings
from scenarios.pilot.depth_frames import camera_mount, posed_image
from scenarios.pilot.landing_phases import (
    COMMIT_HEIGHTS_M,
    MAX_LOOKS,
    MAX_SEARCH_FRAMES,
    SEARCH_FRAMES,
)
from scenarios.pilot.landing_watch import CAMERA, FRAME_PERIOD_US, LandingWatch
from scenarios.pilot.pace import USUAL

WIDTH_PX, HEIGHT_PX = 320, 240
N_CELLS = 80
"""Number of random cells of an area that are judged."""
# The worst of 20 flights with RTK, docs/notebook.md: 0.15 m and 0.34 degrees in three axes.
_POSITION_ERROR_M, _TILT_ERROR_RAD = 0.09, math.radians(0.2)
_ERROR_CORRELATION_S = 10.0
# The vehicle sways about its commanded place and tilts to hold it; the pilot knows both.
_WOBBLE_M, _WOBBLE_RAD, _WOBBLE_CORRELATION_S = 0.04, math.radians(1.5), 0.7
_STEP_S = 1e-6 * FRAME_PERIOD_US


class Wander:
    """A first-order Gauss-Markov process, stationary from the start."""

    def __init__(self, sigma: np.ndarray, correlation_s: float, rng: np.random.Generator) -> None:
        self._sigma, self._rng = sigma, rng
        self._keep = math.exp(-_STEP_S / correlation_s)
        self.value = sigma * rng.standard_normal(len(sigma))

    def step(self) -> None:
        """Advance the process by the period of the frames."""
        fresh = self._sigma * self._rng.standard_normal(len(self._sigma))
        # Scaled so that the variance stays what it was.
        self.value = self._keep * self.value + math.sqrt(1.0 - self._keep**2) * fresh


@dataclass(frozen=True, kw_only=True, eq=False)
class JudgedSite:
    """A site, and the place where the vehicle would really land if it went there."""

    site: LandingSite
    true_enu_m: Float[np.ndarray, " 2"]


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenCells:
    """Map values of some cells when the first site was chosen or the search was given up."""

    true_enu_m: Float[np.ndarray, "n 2"]
    is_safe: Bool[np.ndarray, " n"]
    slope_rad: Float[np.ndarray, " n"]


@dataclass(kw_only=True, eq=False)
class Look:
    """Result of a landing on one area."""

    chosen: JudgedSite | None = None
    """Choice from the hover point in the first search; None if there was none."""
    committed: JudgedSite | None = None
    """Site a metre below the vehicle after the last check; None if the area was given up."""
    cells: SeenCells | None = None
    aborts: list[str] = field(default_factory=list)
    """Reasons of the watch for which descents were called off."""


class LookRig:
    """World with a movable vehicle and its downward camera."""

    def __init__(self, world: World, camera: DepthNoiseCfg | None) -> None:
        self._camera = camera
        self._data = world.new_data()
        self._renderer = open_camera_renderer(world, WIDTH_PX, HEIGHT_PX)

    def frame(
        self, position_enu_m: np.ndarray, quat_wxyz: np.ndarray, rng: np.random.Generator
    ) -> PosedDepth:
        """Render a camera frame from a given pose, with the errors of the camera.

        Args:
            position_enu_m: True position of the vehicle.
            quat_wxyz: True attitude.
            rng: Source of the camera's errors.
        """
        self._data.qpos[:7] = (*position_enu_m, *quat_wxyz)
        frame = self._renderer.render_depth(self._data, CAMERA, 0)
        if self._camera is not None:
            frame.depth_m[:] = measured_depth(frame.depth_m, frame.fx, self._camera, rng)
        return frame

    def close(self) -> None:
        """Release the renderer, which holds memory of the graphics."""
        self._renderer.close()


class Looker:
    """One landing on one area, as the pilot goes about it."""

    def __init__(
        self,
        rig: LookRig,
        surroundings: Surroundings,
        area: InteractionArea,
        hover_enu_m: Vector3,
        rng: np.random.Generator,
    ) -> None:
        self._rig, self._rng = rig, rng
        self._world, self._area, self._hover_enu_m = surroundings, area, hover_enu_m
        self._yaw_rad = rng.uniform(-math.pi, math.pi)
        ones = np.ones(3)
        self._position_error = Wander(_POSITION_ERROR_M * ones, _ERROR_CORRELATION_S, rng)
        self._turn_error = Wander(_TILT_ERROR_RAD * ones, _ERROR_CORRELATION_S, rng)
        self._wobble = Wander(_WOBBLE_M * ones, _WOBBLE_CORRELATION_S, rng)
        self._tilt = Wander(_WOBBLE_RAD * np.array([1.0, 1.0, 0.0]), _WOBBLE_CORRELATION_S, rng)
        self._time_us = 0
        self._mount = camera_mount(surroundings.airframe, CAMERA)

    def land(self) -> Look:
        """Search, choose and descend; climb back and search again if the place turns out bad."""
        look = Look()
        for _ in range(MAX_LOOKS):
            watch = LandingWatch(self._world, self._area, self._hover_enu_m)
            site = self._search(watch)
            # Only the first search counts, so that every area has one choice.
            if look.cells is None:
                look.cells = self._cells(watch)
                look.chosen = self._judged(site)
            if site is None:
                break
            site, reason = self._descend(watch, site)
            if reason is None:
                look.committed = self._judged(site)
                break
            look.aborts.append(reason)
        return look

    def _search(self, watch: LandingWatch) -> LandingSite | None:
        while watch.n_frames < MAX_SEARCH_FRAMES:
            self._glance(watch, np.array(self._hover_enu_m))
            site = watch.choose() if watch.n_frames >= SEARCH_FRAMES else None
            if site is not None:
                return site
        return None

    def _descend(self, watch: LandingWatch, site: LandingSite) -> tuple[LandingSite, str | None]:
        """Descend over a site.

        Returns:
            The site as known from a metre above, and the reason against it, if any.
        """
        height_m = self._hover_enu_m[2]
        leg_m = self._world.airframe.leg_length_m
        while height_m > site.position_enu_m[2] + leg_m + COMMIT_HEIGHTS_M[0]:
            height_m -= USUAL.descent_mps * _STEP_S
            self._glance(watch, np.array([*site.position_enu_m[:2], height_m]))
            site = watch.again(site)
            if reason := watch.objection(site):
                return site, reason
        return site, None

    def _glance(self, watch: LandingWatch, commanded_enu_m: np.ndarray) -> None:
        """Fuse one frame taken where the vehicle believes it is near the commanded position."""
        for wander in (self._position_error, self._turn_error, self._wobble, self._tilt):
            wander.step()
        believed = commanded_enu_m + self._wobble.value
        yaw = Rotation.from_rotvec([0.0, 0.0, self._yaw_rad])
        attitude = yaw * Rotation.from_rotvec(self._tilt.value)
        # The estimate is the truth and its error.
        true = believed - self._position_error.value
        frame = self._rig.frame(true, attitude.as_quat(scalar_first=True), self._rng)
        # In the world: the error turns the attitude that the vehicle has.
        seen_as = Rotation.from_rotvec(self._turn_error.value) * attitude
        quat = tuple(seen_as.as_quat(scalar_first=True).tolist())
        telemetry = Telemetry(position_enu_m=vector3(believed), quat_wxyz=quat)
        self._time_us += FRAME_PERIOD_US
        watch.fuse(self._time_us, posed_image(frame, self._mount, telemetry))

    def _judged(self, site: LandingSite | None) -> JudgedSite | None:
        if site is None:
            return None
        # The vehicle flies to the site in its estimate, and so misses it by the estimate's error.
        true = np.array(site.position_enu_m[:2]) - self._position_error.value[:2]
        return JudgedSite(site=site, true_enu_m=true)

    def _cells(self, watch: LandingWatch) -> SeenCells:
        assert watch.map is not None
        rows, columns = np.nonzero(watch.is_allowed)
        few = self._rng.permutation(len(rows))[:N_CELLS]
        rows, columns = rows[few], columns[few]
        east, north = watch.elevation.cell_centres()
        believed = np.column_stack([east[columns], north[rows]])
        return SeenCells(
            true_enu_m=believed - self._position_error.value[:2],
            is_safe=watch.map.is_safe[rows, columns],
            slope_rad=watch.map.slope_rad[rows, columns],
        )
