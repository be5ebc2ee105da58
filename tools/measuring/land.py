"""Safety of the landing places that the pilot chooses, and quality of its landings.

A depth camera with its errors observes landing areas of many scenes from poses with the
estimator's errors, from the hover point down as the pilot does; vertical rays onto the solids of
the physics judge the choices. Some landings are flown in the whole stack.

A place is unsafe if the vehicle itself, feet and rotors, without any margin, breaks a limit of
slope, height range or rise there. A place is missed if it keeps them with the margin for scatter
but is not recognised as safe.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from aeroscene.sources import load_scene
from autonomy.perception import DepthImage, ElevationMap, assess, camera_pose
from flightsim.cameras.depth_noise import DEPTH_CAMERAS, measured_depth
from flightsim.testbench import TestbenchCfg
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import WorldError, build_world
from measuring.configs import LandBenchCfg
from measuring.landing_flight import fly_landing
from measuring.landing_look import HEIGHT_PX, WIDTH_PX, Look, Looker, LookRig
from measuring.landing_truth import ExactGround
from measuring.plan_pairs import scene_numbers
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.mission.mission import rank_areas
from scenarios.mission.surroundings import MissionError, Surroundings, survey
from scenarios.pilot.depth_frames import camera_mount
from scenarios.pilot.landing_watch import PERCHING_SCATTER_M, SCATTER_M, landing_needs
from scenarios.trials.result import TrialResult

# Targets of the results: percent of the sites and cells, m, m/s and CPU ms.
MOST_UNSAFE_SITES, MOST_UNSAFE_CELLS = 0.5, 2.0
MOST_TOUCHDOWN_ERROR_M, MOST_TOUCHDOWN_SPEED_MPS = 0.10, 0.5
MOST_UPDATE_MS = 8.0
VEHICLES = ("iris", "hummingbird")
_AREAS_A_SCENE = 10  # few, so that many scenes count
_PERCHES_A_SCENE = 2
_N_UPDATES = 40
_LOOK_SHARE = 0.85  # share of the progress that the looks take; the rest are flights


@dataclass(kw_only=True, slots=True)
class _Tally:
    """Results so far for areas of one kind; flags are true for what is bad."""

    n_areas: int = 0
    n_found: int = 0
    chosen: list[bool] = field(default_factory=list)
    """For each site, as first chosen, true if it is unsafe."""
    committed: list[bool] = field(default_factory=list)
    without_margin: list[bool] = field(default_factory=list)
    """For each committed site, true if it would be unsafe somewhere within the scatter."""
    unsafe_cells: list[bool] = field(default_factory=list)
    """For each cell that was taken for safe, true if it is unsafe."""
    missed_cells: list[bool] = field(default_factory=list)
    """For each safe cell, true if it was missed."""
    slope_errors_deg: list[float] = field(default_factory=list)
    aborts: Counter[str] = field(default_factory=Counter)


def rows(cfg: LandBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Observe areas, fly to some and time the map.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Returns:
        Rows of results.
    """
    numbers = scene_numbers(max(2, math.ceil(cfg.areas / _AREAS_A_SCENE)))
    landing, perching = _Tally(), _Tally()
    for index, number in enumerate(numbers):
        on_progress(f"scene {number}", _LOOK_SHARE * index / len(numbers))
        airframe = airframe_by_name(VEHICLES[index % len(VEHICLES)])
        # Makes up for areas that earlier scenes lacked.
        share = cfg.areas * (index + 1) // len(numbers) - landing.n_areas
        _look_at_scene(number, airframe, share, cfg, (landing, perching))
    yield from _site_rows("", landing, MOST_UNSAFE_SITES)
    yield from _cell_rows(landing)
    yield from _site_rows("perches: ", perching, None)
    on_progress("map update", _LOOK_SHARE)
    yield lower("map update, 320 x 240, least", _update_ms(cfg), "CPU ms", MOST_UPDATE_MS)
    yield from _flight_rows(cfg, on_progress)
    on_progress("done", 1.0)


def _look_at_scene(
    number: int, airframe: Airframe, n_areas: int, cfg: LandBenchCfg, tallies: tuple[_Tally, _Tally]
) -> None:
    scene = load_scene(str(number))
    rng = np.random.default_rng([cfg.seed, number])
    landing, perching = tallies
    try:
        surroundings, world = survey(scene, airframe), build_world(scene, airframe)
    except (MissionError, WorldError):
        return  # the vehicle cannot leave the start, or stand there
    ground = ExactGround(world)
    with closing(LookRig(world, DEPTH_CAMERAS.get(cfg.camera))) as rig:
        for areas, most, tally in (
            (rank_areas(scene, airframe, cfg.seed), n_areas, landing),
            (_perches(scene, airframe), _PERCHES_A_SCENE, perching),
        ):
            n_done = 0
            for place in rng.permutation(len(areas)).tolist():
                hover = surroundings.hover_above(areas[place]) if n_done < most else None
                if hover is not None:
                    n_done += 1
                    look = Looker(rig, surroundings, areas[place], hover, rng).land()
                    _judge(look, areas[place], hover[2], surroundings, ground, tally)


def _perches(scene: Scene, airframe: Airframe) -> list[InteractionArea]:
    """Perching places for the vehicle: those made for the feet of small drones."""
    if airframe.drone_class != "small":
        return []
    return [area for area in scene.interaction_areas if area.kind == "perching"]


def _judge(
    look: Look,
    area: InteractionArea,
    from_m: float,
    surroundings: Surroundings,
    ground: ExactGround,
    tally: _Tally,
) -> None:
    scatter_m = PERCHING_SCATTER_M if area.kind == "perching" else SCATTER_M
    bare = landing_needs(surroundings.airframe, 0.0)
    wide = landing_needs(surroundings.airframe, scatter_m)
    tally.n_areas += 1
    tally.n_found += look.committed is not None
    # The first word of a reason names its kind; figures follow.
    tally.aborts.update(reason.split()[0] for reason in look.aborts)
    for sites, site, needs in (
        (tally.chosen, look.chosen, bare),
        (tally.committed, look.committed, bare),
        (tally.without_margin, look.committed, wide),
    ):
        if site is not None:
            is_safe = ground.judge(site.true_enu_m[None], from_m, needs).is_safe
            sites.append(not is_safe[0])
    if look.cells is None or not len(look.cells.is_safe):
        return
    cells, said = look.cells, look.cells.is_safe
    exact = ground.judge(cells.true_enu_m, from_m, bare)
    with_margin = ground.judge(cells.true_enu_m, from_m, wide).is_safe
    tally.unsafe_cells += (~exact.is_safe[said]).tolist()
    # Cells that keep the limits with the margin too should have been recognised.
    tally.missed_cells += (~said[with_margin]).tolist()
    errors = np.abs(cells.slope_rad - exact.slope_rad)[said & exact.is_safe]
    tally.slope_errors_deg += np.degrees(errors).tolist()


def _update_ms(cfg: LandBenchCfg) -> float:
    """CPU time to fuse and judge a frame, ms: level ground 4 m below, a map of 6 x 6 m."""
    airframe = airframe_by_name(VEHICLES[0])
    focal = HEIGHT_PX / 2 / math.tan(camera_mount(airframe, "down").vertical_fov_rad / 2)
    eye, rotation = camera_pose((0.0, 0.0, 4.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), math.pi / 2)
    rng, noise = np.random.default_rng(cfg.seed), DEPTH_CAMERAS.get(cfg.camera)
    elevation, needs = ElevationMap((0.0, 0.0, 0.0)), landing_needs(airframe)
    spent_s = []
    for _ in range(_N_UPDATES):
        depth_m = np.full((HEIGHT_PX, WIDTH_PX), 4.0, dtype=np.float32)
        if noise is not None:
            depth_m = measured_depth(depth_m, focal, noise, rng)
        image = DepthImage(
            depth_m=depth_m,
            fx=focal,
            fy=focal,
            cx=(WIDTH_PX - 1) / 2,
            cy=(HEIGHT_PX - 1) / 2,
            position_enu_m=eye,
            rotation_enu_from_optical=rotation,
        )
        begun_s = time.process_time()
        elevation.add(image)
        assess(elevation, needs)
        spent_s.append(time.process_time() - begun_s)
    # The least, because other processes can only slow an update down.
    return 1e3 * min(spent_s)


def _flight_rows(cfg: LandBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    landings: list[TrialResult] = []
    n_aborts = 0
    n_without = 0
    for index, number in enumerate(scene_numbers(cfg.flights) if cfg.flights else []):
        share = _LOOK_SHARE + (1 - _LOOK_SHARE) * index / cfg.flights
        on_progress(f"flight in scene {number}", share)
        bench = TestbenchCfg(
            vehicle=VEHICLES[index % len(VEHICLES)],
            seed=cfg.seed,
            speed="max",
            depth_camera=cfg.camera,
        )
        try:
            result, n_calls = fly_landing(load_scene(str(number)), bench)
        except MissionError:
            n_without += 1
            continue
        landings.append(result)
        n_aborts += n_calls
    if not landings:
        return
    done = [landing for landing in landings if landing.success]
    yield higher(f"flown: landed, of {len(landings)}", _share(done, landings), "%")
    for reason in (f"{flown.code}: {flown.reason}" for flown in landings if not flown.success):
        yield lower(f"flown: {reason}", 1, "flights")
    if n_without:
        yield lower("flown: scenes without a mission", n_without, "scenes")
    errors = [landing.touchdown_error_m or 0.0 for landing in done]
    speeds = [landing.touchdown_speed_mps or 0.0 for landing in done]
    tilts = [landing.tilt_at_rest_deg or 0.0 for landing in done]
    yield lower("flown: touchdown error, median", _median(errors), "m", MOST_TOUCHDOWN_ERROR_M)
    yield lower("flown: touchdown error, worst", _worst(errors), "m")
    yield lower("flown: speed at touchdown, worst", _worst(speeds), "m/s", MOST_TOUCHDOWN_SPEED_MPS)
    yield lower("flown: tilt at rest, worst", _worst(tilts), "deg")
    yield lower("flown: descents called off", n_aborts, "descents")


def _site_rows(prefix: str, tally: _Tally, target: float | None) -> Iterator[Row]:
    yield higher(f"{prefix}areas looked at", tally.n_areas, "areas")
    if not tally.n_areas:
        return
    found = 100 * tally.n_found / tally.n_areas
    yield higher(f"{prefix}areas with a site to land on", found, "%")
    for title, sites, promised in (
        ("unsafe sites, as first chosen", tally.chosen, target),
        ("unsafe sites, committed to at the last look", tally.committed, target),
        ("committed to, unsafe within the scatter", tally.without_margin, None),
    ):
        yield lower(f"{prefix}{title}", _percent(sites), f"% of {len(sites)}", promised)
    yield lower(f"{prefix}descents called off", tally.aborts.total(), "descents")
    for word, count in sorted(tally.aborts.items()):
        yield lower(f"{prefix}called off: {word}", count, "descents")


def _cell_rows(tally: _Tally) -> Iterator[Row]:
    for title, cells, target in (
        ("unsafe cells among those taken for safe", tally.unsafe_cells, MOST_UNSAFE_CELLS),
        ("safe cells missed", tally.missed_cells, None),
    ):
        yield lower(title, _percent(cells), f"% of {len(cells)}", target)
    errors = tally.slope_errors_deg
    yield lower("slope error, median", _median(errors), "deg")
    p95 = float(np.quantile(errors, 0.95)) if errors else math.nan
    yield lower("slope error, p95", p95, "deg")


def _share(part: list[TrialResult], whole: list[TrialResult]) -> float:
    return 100 * len(part) / len(whole)


def _percent(flags: list[bool]) -> float:
    return 100 * sum(flags) / len(flags) if flags else math.nan


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else math.nan


def _worst(values: list[float]) -> float:
    return max(values) if values else math.nan
