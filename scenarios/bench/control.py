"""`bench control`: tracking accuracy of the controller, and its robustness.

The parts are: hover throttle and step responses; figure eights with a peak acceleration of 7 m/s^2,
with the true state and with the estimator in the loop, in still air and in 5 m/s of wind with
moderate turbulence; eights that no rotor can fly; recovery from random attitudes and rates. All fly
in an empty field, in MuJoCo with rotor lag. The true state shows the controller's own error, and
the estimator in the loop shows what noise and delay add.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from flightsim.environment.wind import CALM, TURBULENCE_MPS, WindCfg
from flightsim.plant import Plant, PlantCfg, compile_kernels
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world
from scenarios.bench.configs import ControlBenchCfg
from scenarios.bench.figure_eight import FigureEight, Track, come_back, fly, take_off
from scenarios.bench.manoeuvres import meadow
from scenarios.bench.recovery import Recovery, recover
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.bench.step_response import ASIDE_M, ROLL_RAD, step_response

PEAK_ACCELERATION_MPS2 = 7.0
WIND_MPS = 5.0
LARGEST_RMSE_M = {
    ("truth", "still air"): 0.05,
    ("truth", "wind"): 0.15,
    ("estimate", "still air"): 0.10,
    ("estimate", "wind"): 0.20,
}
"""Targets for the Hummingbird, m. With the estimator in the loop, the error is relative to the
estimate."""
LEAST_RECOVERED_PERCENT = 99.9
_TARGET_VEHICLE = "hummingbird"
_LAPS = 3
_WIND_SETTLES_S = 4.0  # hover in the wind before the eight begins
_TOO_FAST_MPS2 = (16.0, 20.0, 25.0, 30.0, 35.0)
"""Peak accelerations of eights beyond the limits of tilt and thrust."""
_TOO_FAST_S, _COME_BACK_S = 25.0, 15.0  # at 10 m/s it brakes and returns over 20 m
_LOST_RAD = math.radians(90.0)
_BACK_M = 0.2


def rows(cfg: ControlBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Fly and judge all parts, for each vehicle.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called before each part.

    Yields:
        Rows in the order of the parts.
    """
    compile_kernels()
    for i, name in enumerate(cfg.vehicles):
        done = i / len(cfg.vehicles)
        world = build_world(meadow(has_room=False), airframe_by_name(name))
        on_progress(f"{name}: step responses", done)
        yield from _steps(cfg, name, world)
        on_progress(f"{name}: figure eights", done + 0.05 / len(cfg.vehicles))
        yield from _tracking(cfg, name, world)
        on_progress(f"{name}: beyond its limits", done + 0.15 / len(cfg.vehicles))
        yield from _saturation(cfg, name, world)
        on_progress(f"{name}: recovery", done + 0.2 / len(cfg.vehicles))
        yield from _recovery(cfg, name, world)
    on_progress("done", 1.0)


def _steps(cfg: ControlBenchCfg, name: str, world: World) -> Iterator[Row]:
    found = step_response(world, cfg.seed)
    yield lower(f"{name}, hover throttle", 100.0 * found.hover_throttle, "%")
    title = f"{name}, step of {math.degrees(ROLL_RAD):.0f} degrees of roll"
    yield lower(f"{title}: rise from 10 to 90 %", found.roll_rise_s, "s")
    yield lower(f"{title}: overshoot", 100.0 * found.roll_overshoot, "%")
    title = f"{name}, step of {ASIDE_M:g} m aside"
    yield lower(f"{title}: within 5 cm after", found.aside_settled_s, "s")
    yield lower(f"{title}: overshoot", found.aside_overshoot_m, "m")


def _tracking(cfg: ControlBenchCfg, name: str, world: World) -> Iterator[Row]:
    for state in ("truth", "estimate"):
        for air in ("still air", "wind"):
            n_flights = cfg.flights if air == "wind" else 1
            errors_m = []
            for k in range(n_flights):
                # From all sides, because an eight is not the same along and across the wind.
                wind = _wind(360.0 * k / n_flights) if air == "wind" else CALM
                plant = Plant(world, PlantCfg(seed=cfg.seed + k, state=state))
                errors_m.append(_fly_eight(plant, wind).rmse_m(state))
            target = LARGEST_RMSE_M[state, air] if name == _TARGET_VEHICLE else None
            title = f"{name}, figure eight by {state}, {air}"
            # Flights are of equal length, so their mean square is that of all samples.
            rmse_m = math.sqrt(np.mean(np.square(errors_m)))
            yield lower(title, rmse_m, "m RMSE", target)
            if n_flights > 1:
                worst_m = max(errors_m)
                metric = f"{title}, worst flight"
                yield lower(metric, worst_m, "m RMSE")


def _wind(from_deg: float) -> WindCfg:
    return WindCfg(speed_mps=WIND_MPS, from_deg=from_deg, turbulence_mps=TURBULENCE_MPS["moderate"])


def _fly_eight(plant: Plant, wind: WindCfg) -> Track:
    hover_enu_m = take_off(plant)
    plant.wind = wind
    come_back(plant, hover_enu_m, _WIND_SETTLES_S)
    eight = FigureEight(centre_enu_m=hover_enu_m, peak_acceleration_mps2=PEAK_ACCELERATION_MPS2)
    return fly(plant, eight, _LAPS * eight.lap_s)


def _saturation(cfg: ControlBenchCfg, name: str, world: World) -> Iterator[Row]:
    """Fly eights that are too fast, then come back; a vehicle that tips or stays away is lost."""
    n_lost, tilt_rad, sunk_m = 0, 0.0, 0.0
    for peak_mps2 in _TOO_FAST_MPS2:
        plant = Plant(world, PlantCfg(seed=cfg.seed, state="truth"))
        hover_enu_m = take_off(plant)
        eight = FigureEight(centre_enu_m=hover_enu_m, peak_acceleration_mps2=peak_mps2)
        away = fly(plant, eight, _TOO_FAST_S)
        back = come_back(plant, hover_enu_m, _COME_BACK_S)
        largest_rad = max(away.tilt_rad.max(), back.tilt_rad.max())
        # A vehicle that is elsewhere after 15 s has lost its place for good.
        is_back = np.linalg.norm(back.error_true_m[-1]) < _BACK_M
        has_touched = away.is_touching.any() or back.is_touching.any()
        n_lost += largest_rad >= _LOST_RAD or has_touched or not is_back
        tilt_rad = max(tilt_rad, largest_rad)
        sunk_m = max(sunk_m, -away.error_true_m[:, 2].min())
    title = f"{name}, references beyond its limits"
    yield lower(f"{title}: lost", float(n_lost), "flights", 0.0)
    tilt_deg = math.degrees(tilt_rad)
    yield lower(f"{title}: largest tilt", tilt_deg, "degrees")
    yield lower(f"{title}: height lost", sunk_m, "m")


def _recovery(cfg: ControlBenchCfg, name: str, world: World) -> Iterator[Row]:
    # One source for all trials, so that a larger --count repeats the first ones.
    rng = np.random.default_rng(cfg.seed)
    trials = [recover(world, cfg.seed, rng) for _ in range(cfg.count)]
    share = 100.0 * float(np.mean([trial.is_recovered for trial in trials]))
    title = f"{name}, recovery from any attitude and rate"
    yield higher(title, share, "%", LEAST_RECOVERED_PERCENT)
    yield from _spread(f"{title}: height lost", "m", trials, lambda trial: trial.height_lost_m)
    yield from _spread(f"{title}: upright after", "s", trials, lambda trial: trial.upright_s)


def _spread(
    title: str, unit: str, trials: list[Recovery], value: Callable[[Recovery], float]
) -> Iterator[Row]:
    values = [value(trial) for trial in trials]
    for name, share in (("median", 50.0), ("p95", 95.0), ("most", 100.0)):
        figure = float(np.percentile(values, share))
        yield lower(f"{title}, {name}", figure, unit)
