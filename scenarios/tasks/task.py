"""Task of one trial: everything that determines its flight, besides the pilot and the code.

A task is plain numbers and words. Two campaigns are comparable trial by trial if their tasks are
equal, and a row of results can be flown again.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from aeroscene.scene import Scene
from autonomy.types import Vector3
from flightsim.looks.weather import Season
from flightsim.testbench import TestbenchCfg
from flightsim.vehicles import airframe_by_name
from scenarios.mission.surroundings import MapSource
from scenarios.run.cfg import SitlCfg
from scenarios.tasks.path_difficulty import PathFigures, least_navigation_s


@dataclass(frozen=True, kw_only=True, slots=True)
class Task:
    """A flight from a start to an area, and the conditions under which it is flown."""

    family: str
    """Family whose recipe the task is drawn from; empty if a campaign has one recipe."""
    scene: str
    """Name of the scene, as `load_scene` takes it."""
    vehicle: str
    trial: int
    """Number of the trial among those of this scene and vehicle."""
    seed: int
    """Seed of the flight: noise, turbulence, traffic."""
    start: Vector3
    """Point to stand on at first, ENU, m."""
    start_yaw_rad: float
    area: int
    """Area to land on; for a goal in words, the area of its place with the shortest path."""
    goal: Literal["area", "naming", "relation", "chain"]
    """How the pilot learns its goal."""
    text: str | None
    """Goal in words."""
    goal_areas: tuple[int, ...]
    """Areas on which a landing is a success."""
    time_limit_s: float
    """Simulated time in which it must have landed."""
    wind_mps: float
    wind_from_deg: float
    turbulence: str
    gust_mps: float
    traffic: str
    gnss: Literal["rtk", "standard"]
    depth_camera: Literal["exact", "d435", "d455"]
    map: MapSource
    """"truth" if the map is given to the pilot, "onboard" if it must make its own."""
    aiding: Literal["gnss", "vio", "mocap", "auto"]
    """Source of the position."""
    failures: str
    """Parts that fail in flight and when, as `aeroscene sitl --fail` has them."""
    light: str
    """Time of day and weather of camera images, as `aeroscene sitl --light` has them."""
    season: Season
    """Season of leaves, grass and the date of the light."""
    navigation_limit_s: float | None
    """Time after lift-off in which it must have come above its area; None for any."""
    way: PathFigures
    """Figures of the shortest path, and the grade that follows from them."""

    @property
    def trial_id(self) -> str:
        """Name of the trial, unique within a campaign: scene/vehicle/number."""
        return trial_id(self.scene, self.vehicle, self.trial, self.family)

    def cfg(self) -> SitlCfg:
        """Return the configuration of the run that flies the task."""
        return SitlCfg(
            scene=self.scene,
            area=self.area,
            goal=self.goal,
            map=self.map,
            navigation_limit_s=self.navigation_limit_s,
            headless_seconds=self.time_limit_s,
            bench=TestbenchCfg(
                vehicle=self.vehicle,
                seed=self.seed,
                gnss=self.gnss,
                wind=self.wind_mps,
                wind_from=self.wind_from_deg,
                turbulence=self.turbulence,
                gust=self.gust_mps,
                traffic=self.traffic,
                depth_camera=self.depth_camera,
                aiding=self.aiding,
                fail=self.failures,
                light=self.light,
                season=self.season,
                # As fast as possible: no client outside of the process waits for real time.
                speed="max",
            ),
        )

    def place(self, scene: Scene) -> Scene:
        """Return the scene with the start of the task.

        Args:
            scene: The scene that the task names.
        """
        # The areas stay: the goal's number must mean the same area from every start.
        return replace(scene, start_position_enu_m=self.start, start_yaw_rad=self.start_yaw_rad)

    def to_plain(self) -> dict[str, Any]:
        """Return the task as plain data, flat: the figures of the path stand beside the rest."""
        # A column of a table holds a number or a word, so the path's figures move up a level.
        plain = asdict(self)
        way = plain.pop("way")
        # It follows from path and vehicle, so the task need not hold it.
        least_s = least_navigation_s(self.way.way_m, airframe_by_name(self.vehicle))
        return {
            "trial_id": self.trial_id,
            **plain,
            **way,
            "least_navigation_s": round(least_s, 3),
            "difficulty": self.way.grade,
        }


def trial_id(scene: str, vehicle: str, trial: int, family: str = "") -> str:
    """Return the name of a trial, which begins with its family if it has one."""
    return "/".join([*([family] if family else []), scene, vehicle, str(trial)])
