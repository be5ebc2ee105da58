"""Encounters of the whole stack with drones that come its way: does it keep clear of them?

Each scene is first flown with nobody near: this flight gives the place of the vehicle at each time.
Then one drone a flight is at that place at that time, from ahead, from the side, from above or from
below. It heeds nobody. The pilot sees it by its depth camera alone, and the truth judges.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from autonomy.types import Vector3
from flightsim.environment.movers import MovingObstacle
from flightsim.testbench import TestbenchCfg, TestbenchError
from measuring.configs import EncountersBenchCfg
from measuring.meeting import DIRECTIONS, Direction, FlownWay, draw_meeting
from measuring.plan_pairs import SHIPPED_SCENES
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.mission.surroundings import MissionError, Surroundings
from scenarios.pilot import Phase
from scenarios.run.cfg import SitlCfg
from scenarios.run.hangar import Hangar
from scenarios.run.sitl import Sitl
from scenarios.trials.result import TrialResult

# Least gap between the hulls that counts as kept clear.
LEAST_GAP_M = 0.3
_VEHICLES = ("iris", "hummingbird")
# Coprime to the number of scenes.
_STEP = 613
"""Scenes are taken in steps of this many, which visit all of them in turn."""
_RISEN_M = 0.5
"""Rise from which a vehicle flies: a drone that crosses the start earlier meets one that stands."""
# Farther than anything looks.
_FAR_ENU_M = (0.0, 0.0, 400.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Flight:
    """A flight: its result, its path and its phases."""

    result: TrialResult
    way: FlownWay
    begins_s: Mapping[Phase, float]
    """Time at which the pilot first came to each phase."""
    surroundings: Surroundings


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rehearsal:
    """A flight that met nobody."""

    way: FlownWay
    between_s: tuple[float, float]
    """Time from the climb until the pilot looks down for a place, in which drones may come."""
    surroundings: Surroundings

    def is_free(self, places_enu_m: np.ndarray, room_m: float) -> np.ndarray:
        """True for places at which the scene leaves room for a sphere."""
        return self.surroundings.map.distance_m(places_enu_m) > room_m


def rows(cfg: EncountersBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Meet drones in one scene after the other until there were enough encounters.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Returns:
        Rows of results, of all directions and of each.
    """
    met: dict[Direction, list[TrialResult]] = defaultdict(list)
    n_met, number, n_scenes = 0, cfg.seed, 0
    with Hangar() as hangar:
        while n_met < cfg.count and n_scenes < SHIPPED_SCENES:
            vehicle = _VEHICLES[n_scenes % len(_VEHICLES)]
            number, n_scenes = (number + _STEP) % SHIPPED_SCENES, n_scenes + 1
            on_progress(f"scene {number}, {vehicle}: alone", n_met / cfg.count)
            scene, bench = (
                load_scene(str(number)),
                TestbenchCfg(vehicle=vehicle, speed="max", seed=cfg.seed),
            )
            rehearsal = _rehearse(scene, bench, hangar)
            if rehearsal is None:
                continue
            # Of the scene too, so that its encounters are the same wherever the benchmark begins.
            rng = np.random.default_rng([cfg.seed, number])
            for direction in DIRECTIONS:
                mover = draw_meeting(
                    rehearsal.way, rehearsal.between_s, direction, rehearsal.is_free, rng
                )
                if mover is None or n_met >= cfg.count:
                    continue
                on_progress(f"scene {number}, {vehicle}: {direction}", n_met / cfg.count)
                met[direction].append(_fly(scene, bench, hangar, mover).result)
                n_met += 1
    yield from _rows(met)


def _rehearse(scene: Scene, bench: TestbenchCfg, hangar: Hangar) -> _Rehearsal | None:
    """Fly a scene with a drone far above; None without a mission or a landing."""
    # With a drone far away rather than none, so that only the meeting is new afterwards.
    x, y, z = _FAR_ENU_M
    far = MovingObstacle(kind="drone", path_enu_m=((x, y, z), (x + 5.0, y, z)), speed_mps=1.0)
    try:
        flight = _fly(scene, bench, hangar, far)
    except TestbenchError as error:
        if isinstance(error.__cause__, MissionError):
            return None
        raise
    if not flight.result.success:
        return None
    way, begins = flight.way, flight.begins_s
    is_up = way.position_enu_m[:, 2] > way.position_enu_m[0, 2] + _RISEN_M
    between_s = (float(way.time_s[is_up][0]), begins[Phase.SEARCH])
    return _Rehearsal(way=way, between_s=between_s, surroundings=flight.surroundings)


def _fly(scene: Scene, bench: TestbenchCfg, hangar: Hangar, mover: MovingObstacle) -> _Flight:
    """Fly the scene's demo in the presence of one mover."""
    times_s: list[float] = []
    places: list[Vector3] = []
    cfg = SitlCfg(demo=True, bench=bench)
    with Sitl(cfg, scene=scene, has_network=False, hangar=hangar, movers=(mover,)) as sitl:
        plant, pilot = sitl.bench.plant, sitl.pilot
        assert pilot is not None

        def note() -> None:
            times_s.append(plant.time_us * 1e-6)
            places.append(plant.truth.position_enu_m)

        sitl.bench.observers.append(note)
        result = sitl.run()
        return _Flight(
            result=result,
            way=FlownWay(time_s=np.array(times_s), position_enu_m=np.array(places)),
            # Backwards, so that the first time of a phase is the one that stays.
            begins_s={c.target: c.time_us * 1e-6 for c in reversed(pilot.transitions)},
            surroundings=pilot.mission.surroundings,
        )


def _rows(met: Mapping[Direction, Sequence[TrialResult]]) -> Iterator[Row]:
    everything = [result for results in met.values() for result in results]
    for name, results in (("", everything), *((f"{name}: ", met[name]) for name in DIRECTIONS)):
        yield higher(f"{name}encounters", len(results), "flights")
        if not results:
            continue
        gaps_m = [math.inf if r.nearest_mover_m is None else r.nearest_mover_m for r in results]
        n_near = sum(gap_m < LEAST_GAP_M for gap_m in gaps_m)
        yield lower(f"{name}nearer than {LEAST_GAP_M:g} m", n_near, "flights", 0)
        yield higher(f"{name}nearest, least", min(gaps_m), "m")
        yield higher(f"{name}nearest, median", float(np.median(gaps_m)), "m")
        landed = 100 * sum(bool(result.success) for result in results) / len(results)
        yield higher(f"{name}landed on the area", landed, "%")
