"""Consistency, accuracy and cost of the filter: `tools/bench.py estimate`.

Short flights of the plant alone, each with its own noise and curves; every second the error against
the truth is compared with the covariance that the filter claims.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float

from autonomy.estimation.error_state import MEASUREMENTS
from flightsim.environment.wind import CALM, SIGMA_OVER_W20, WindCfg
from flightsim.plant import Plant, PlantCfg, compile_kernels
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world
from measuring.configs import EstimateBenchCfg
from measuring.consistency import BLOCKS, band, errors, nees
from measuring.filter_step import step_us
from scenarios.bench.manoeuvres import curves, fly, meadow, visit
from scenarios.bench.row import OnProgress, Row, higher, lower

STEP_LIMIT_US = 20.0
JUMP_LIMIT_M = 0.1
_VISIT_S = 50.0  # into the room, a while there, and out
_WIND_MPS = 5.0
_WIND = WindCfg(speed_mps=_WIND_MPS, from_deg=233.0, turbulence_mps=SIGMA_OVER_W20 * _WIND_MPS)
_UNITS = {"position": ("m", 1.0), "velocity": ("m/s", 1.0), "attitude": ("deg", 180.0 / math.pi)}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A source of position, with the sensors and the wind that it is tested with."""

    title: str
    aiding: Literal["gnss", "vio", "mocap", "auto"]
    gnss: Literal["rtk", "standard"] = "rtk"
    imu: Literal["px4", "adis16448"] = "px4"
    wind: WindCfg = CALM


CASES = (
    Case(title="GNSS (RTK) and VIO", aiding="auto"),
    Case(title="RTK", aiding="gnss"),
    Case(title="standard GNSS", aiding="gnss", gnss="standard"),
    Case(title="VIO", aiding="vio"),
    Case(title="motion capture", aiding="mocap"),
    Case(title="RTK, biased IMU", aiding="gnss", imu="adis16448"),
    Case(title="RTK, 5 m/s of wind with turbulence", aiding="gnss", wind=_WIND),
)


@dataclass(frozen=True)
class Flights:
    """Samples of all flights of a case, every second."""

    nees: dict[str, Float[np.ndarray, "flights instants"]]
    error: dict[str, Float[np.ndarray, "flights instants 3"]]
    wind_error_mps: Float[np.ndarray, "flights 2"]
    """Wind error at the end of each flight, when the filter has had time to find the wind."""
    innovation_square_sum: Float[np.ndarray, " kinds"]
    n_innovations: Float[np.ndarray, " kinds"]


@dataclass
class _Log:
    """Samples of one flight."""

    nees: list[dict[str, float]] = field(default_factory=list)
    error: list[dict[str, np.ndarray]] = field(default_factory=list)


def rows(cfg: EstimateBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Run every part of the benchmark.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Raises:
        AirframeError: If there is no such vehicle.
    """
    airframe = airframe_by_name(cfg.vehicle)
    # Beforehand, so that no flight pays for it.
    compile_kernels()
    world = build_world(meadow(has_room=False), airframe)
    for number, case in enumerate(CASES):
        on_progress(case.title, number / (len(CASES) + 2))
        flights = fly_case(world, case, cfg)
        yield from _consistency_rows(case, flights)
        yield from _error_rows(case, flights)
        if number == 0:
            yield from _innovation_rows(case, flights)
    on_progress("through a door", len(CASES) / (len(CASES) + 2))
    yield from _door_rows(build_world(meadow(has_room=True), airframe), cfg)
    on_progress("step of the filter", (len(CASES) + 1) / (len(CASES) + 2))
    yield from _step_rows(world, cfg)
    on_progress("done", 1.0)


def fly_case(world: World, case: Case, cfg: EstimateBenchCfg) -> Flights:
    """Make all flights of a case.

    Args:
        world: World with the vehicle.
        case: Case.
        cfg: Options of the benchmark.
    """
    logs, winds, squares, counts = [], [], 0.0, 0.0
    for seed in range(cfg.seed, cfg.seed + cfg.count):
        plant = Plant(
            world,
            PlantCfg(seed=seed, aiding=case.aiding, gnss=case.gnss, imu=case.imu, wind=case.wind),
        )
        log = _Log()
        # The second number makes a stream of draws of its own: the plant has the seed alone.
        for time_s in fly(plant, curves(np.random.default_rng((seed, 1))), cfg.seconds):
            if math.isclose(time_s, round(time_s), abs_tol=1e-6):
                log.nees.append(nees(plant))
                log.error.append(errors(plant))
        logs.append(log)
        air = plant.air_velocity_true_enu_mps
        winds.append(np.subtract(plant.wind_est_enu_mps, air[:2]))
        squares += plant.filter["innovation_square_sum"]
        counts += plant.filter["n_innovations"]
    return Flights(
        nees={b: np.array([[at[b] for at in log.nees] for log in logs]) for b in BLOCKS},
        error={b: np.array([[at[b] for at in log.error] for log in logs]) for b in BLOCKS},
        wind_error_mps=np.array(winds),
        innovation_square_sum=np.array(squares),
        n_innovations=np.array(counts),
    )


def _consistency_rows(case: Case, flights: Flights) -> Iterator[Row]:
    """Mean NEES of each block between the ends of its band, and how often it lies there."""
    for block, values in flights.nees.items():
        limits = band(len(values))
        by_instant = values.mean(axis=0)
        is_inside = (by_instant >= limits.low) & (by_instant <= limits.high)
        metric, mean = f"{case.title}: NEES of {block}", float(values.mean())
        yield lower(f"{metric}, not above", mean, "", limits.high)
        yield higher(f"{metric}, not below", mean, "", limits.low)
        yield higher(f"{metric}, seconds inside", 100.0 * is_inside.mean(), "%")


def _error_rows(case: Case, flights: Flights) -> Iterator[Row]:
    for block, error in flights.error.items():
        unit, scale = _UNITS[block]
        rms = scale * math.sqrt(np.mean(np.sum(error**2, axis=-1)))
        yield lower(f"{case.title}: error of {block}, RMS", rms, unit)
    wind = math.sqrt(np.mean(np.sum(flights.wind_error_mps**2, axis=-1)))
    yield lower(f"{case.title}: error of wind, RMS", wind, "m/s")


def _innovation_rows(case: Case, flights: Flights) -> Iterator[Row]:
    """Mean squared innovation over its variance, for each kind: 1 if its noise is as specified."""
    for kind, square, n in zip(
        MEASUREMENTS, flights.innovation_square_sum, flights.n_innovations, strict=True
    ):
        if n > 0:
            yield higher(f"{case.title}: NIS of {kind}", square / n, "")


def _door_rows(world: World, cfg: EstimateBenchCfg) -> Iterator[Row]:
    """Largest step of the estimate beyond its own velocity, on the way in and out."""
    jumps, errors_m, indoors = [], [], []
    for seed in range(cfg.seed, cfg.seed + cfg.count):
        plant = Plant(world, PlantCfg(seed=seed, aiding="auto"))
        history: list[np.ndarray] = []
        is_fixed: list[bool] = []
        for _ in fly(plant, visit(np.random.default_rng((seed, 2))), _VISIT_S):
            history.append(plant.history.copy())
            is_fixed.append(plant.sensors.gnss.fix_type > 1)
        h = np.concatenate(history)
        jumps.append(largest_jump(h))
        error = np.linalg.norm(h["position_est_enu_m"] - h["position_true_enu_m"], axis=1)
        errors_m.append(error)
        # A fix is known once an advance, the history has a row for each tick.
        indoors.append(np.repeat(~np.array(is_fixed), len(plant.history)))
    is_lost, error_m = np.concatenate(indoors), np.concatenate(errors_m)
    yield lower("through a door: largest jump of the estimate", max(jumps), "m", JUMP_LIMIT_M)
    for name, where in (("without fix", is_lost), ("with fix", ~is_lost)):
        rms = math.sqrt(np.mean(error_m[where] ** 2)) if where.any() else math.nan
        yield lower(f"through a door: error {name}, RMS", rms, "m")
    yield higher("through a door: time without fix", 100.0 * is_lost.mean(), "%")


def largest_jump(history: np.ndarray) -> float:
    """Largest change of the estimated position in a tick beyond what its velocity explains, m.

    Args:
        history: Rows of a plant's history, one a tick.
    """
    position, velocity = history["position_est_enu_m"], history["velocity_est_enu_mps"]
    dt_s = 1e-6 * np.diff(history["time_us"])[:, None]
    jump = np.diff(position, axis=0) - velocity[1:] * dt_s
    return float(np.linalg.norm(jump, axis=1).max())


def _step_rows(world: World, cfg: EstimateBenchCfg) -> Iterator[Row]:
    plant = Plant(world, PlantCfg(seed=cfg.seed, aiding="auto"))
    # Flown to its end; the times are not wanted.
    deque(fly(plant, curves(np.random.default_rng(cfg.seed)), 1.0), maxlen=0)
    filters = np.array([plant.filter])
    for metric, has_all in (
        ("step of the filter, mean at the sensors' rates", False),
        ("step of the filter with every measurement", True),
    ):
        yield lower(metric, step_us(filters, has_all=has_all), "us", STEP_LIMIT_US)
