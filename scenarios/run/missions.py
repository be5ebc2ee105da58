"""Missions of our own pilots: one for each vehicle of a world, to areas apart.

Two vehicles at one area would meet there. Areas are therefore given out in order: each vehicle
draws among those that are far from the areas and starts of the others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from aeroscene.scene import InteractionArea
from flightsim.testbench import TestbenchError, Vehicle
from scenarios.run.cfg import SitlCfg

if TYPE_CHECKING:
    from flightsim.mavlink.client import MavlinkClient
    from scenarios.mission.mission import Mission
    from scenarios.pilot import Pilot
    from scenarios.pilot.depth_frames import Frames
    from scenarios.words.goal_drawing import WordGoal

_APART_M = 4.0
"""Least distance between the areas of two vehicles, and from the start of another one."""


def plan_missions(
    cfg: SitlCfg, vehicles: Sequence[Vehicle], area: InteractionArea | None
) -> list[Mission]:
    """Plan a mission for each vehicle, none near another one's.

    Args:
        cfg: Configuration of the run.
        vehicles: The vehicles of one world.
        area: Area of the first vehicle; None draws it too.

    Raises:
        TestbenchError: If there is none for one of them.
    """
    # casadi and the kernels of planning and perception: only if our pilot flies.
    from scenarios.mission.mission import plan_mission
    from scenarios.mission.surroundings import MissionError
    from scenarios.pilot.pace import AMONG_MOVERS
    from scenarios.run.kernels import announce_pilot_kernels

    has_traffic = any(_meets_movers(vehicle) for vehicle in vehicles)
    announce_pilot_kernels(cfg.map, expects_traffic=has_traffic)
    missions: list[Mission] = []
    for number, vehicle in enumerate(vehicles):
        others = [other for other in vehicles if other is not vehicle]
        # Starts of all others, and areas of those before: later ones do not exist yet.
        taken = [other.scene.start_position_enu_m for other in others]
        taken += [mission.area.centroid for mission in missions]
        try:
            mission = plan_mission(
                vehicle.scene,
                vehicle.airframe,
                seed=vehicle.cfg.seed,
                area=area if number == 0 else None,
                target=cfg.target,
                map_source=cfg.map,
                method=cfg.planner,
                limits=AMONG_MOVERS.limits if _meets_movers(vehicle) else None,
                is_free=_apart_from(taken),
            )
        except MissionError as error:
            who = f"vehicle {number + 1}: " if others else ""
            raise TestbenchError(f"{who}{error}") from error
        missions.append(mission)
    return [
        # Alternates are filtered at the end, when all areas are known.
        replace(mission, alternates=_left_to(mission, [m for m in missions if m is not mission]))
        for mission in missions
    ]


def plan_to_words(cfg: SitlCfg, vehicle: Vehicle, goal: WordGoal) -> Mission:
    """Plan our pilot's mission to a goal in words.

    Our pilot stands for perfect perception and perfect reading: it evaluates the text on the
    scene's own objects. So its failures are failures of flying alone.

    Args:
        cfg: Configuration of the run.
        vehicle: The vehicle.
        goal: The goal.

    Raises:
        TestbenchError: If none of the areas can be flown to.
    """
    from scenarios.words.perfect_perception import perceived_areas

    fault: TestbenchError | None = None
    areas = perceived_areas(vehicle.scene, goal.description, vehicle.airframe)
    for area in areas:
        try:
            (mission,) = plan_missions(cfg, [vehicle], area)
        except TestbenchError as error:
            # The first failure is the one that is reported.
            fault = fault or error
        else:
            return replace(mission, alternates=tuple(each for each in areas if each != area))
    raise fault or TestbenchError(f"scene {vehicle.scene.scene_id}: nothing fits {goal.text!r}")


def new_pilot(
    vehicle: Vehicle, mission: Mission, frames: Frames, client: MavlinkClient | None = None
) -> Pilot:
    """Return our pilot for a vehicle; it looks out if anything else moves.

    Args:
        vehicle: The vehicle.
        mission: Mission to fly.
        frames: Renders the present frame of a named camera.
        client: Client by which it steers; None takes a new one.
    """
    from scenarios.pilot import Pilot, PilotCfg

    brief = PilotCfg(expects_traffic=_meets_movers(vehicle))
    return Pilot(client or vehicle.connect(), mission, frames, brief)


def _meets_movers(vehicle: Vehicle) -> bool:
    world = vehicle.plant.world
    return bool(world.obstacles) or world.n_vehicles > 1


def _left_to(mission: Mission, others: Sequence[Mission]) -> tuple[InteractionArea, ...]:
    """Return the alternates of a mission that lie apart from the areas of others."""
    is_free = _apart_from([other.area.centroid for other in others])
    return tuple(area for area in mission.alternates if is_free(area))


def _apart_from(
    taken_enu_m: Sequence[tuple[float, float, float]],
) -> Callable[[InteractionArea], bool]:
    return lambda area: all(math.dist(area.centroid, place) >= _APART_M for place in taken_enu_m)
