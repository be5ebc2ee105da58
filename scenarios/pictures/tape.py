"""Tape of a flight, which gathers the data of its pictures while the flight goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flightsim.environment.movers import mover_name
from flightsim.vehicles.builder import vehicle_name
from scenarios.pictures.story import (
    FlightStory,
    LandingLayers,
    MoverPath,
    PlannedLeg,
    Track,
    title_of,
)

if TYPE_CHECKING:
    from autonomy.planning import Trajectory
    from flightsim.autopilot.reports import FlightReports
    from flightsim.plant import Plant
    from scenarios.pilot import Pilot

PLAN_STEP_S = 0.1
"""Time from one drawn point of a plan to the next."""
_MOVER_TICKS = 5
"""Ticks of 20 ms between two samples of the movers."""
_FIELDS = ("position_true_enu_m", "position_est_enu_m", "reference_position_enu_m")


class FlightTape:
    """Samples a run after every tick; call `story` when it is over."""

    def __init__(
        self,
        plant: Plant,
        autopilot: FlightReports,
        pilot: Pilot | None,
        other_plants: Sequence[Plant] = (),
    ) -> None:
        """Follow a vehicle.

        Args:
            plant: Plant of the vehicle.
            autopilot: Reports of its flight stack, which say whether it is armed.
            pilot: Our own pilot, if it flies.
            other_plants: Other vehicles in the same world, whose paths are shown too.
        """
        self._plant = plant
        self._other_plants = other_plants
        self._autopilot = autopilot
        self._pilot = pilot
        self._times_us: list[int] = []
        self._rows: list[tuple[np.ndarray, ...]] = []
        self._is_armed: list[bool] = []
        self._movers: list[np.ndarray] = []
        self._plans: list[PlannedLeg] = []
        self._plan: Trajectory | None = None
        self._first_phase = "" if pilot is None else pilot.phase.value

    @property
    def has_any(self) -> bool:
        """True if at least two moments were sampled, which a path needs."""
        return len(self._times_us) > 1

    def on_tick(self) -> None:
        """Sample the present moment."""
        plant = self._plant
        last = plant.history[-1]
        self._times_us.append(plant.time_us)
        self._rows.append(tuple(last[field].copy() for field in _FIELDS))
        self._is_armed.append(self._autopilot.is_armed)
        has_movers = plant.world.obstacles or self._other_plants
        if has_movers and len(self._times_us) % _MOVER_TICKS == 0:
            others_enu_m = [other.truth.position_enu_m for other in self._other_plants]
            movers_enu_m = plant.obstacles_true.position_enu_m
            # Reshaped, because an empty list of plants would have one dimension only.
            self._movers.append(np.concatenate([movers_enu_m, np.reshape(others_enu_m, (-1, 3))]))
        # The pilot plans before it arms, but only the plan that is current then is flown.
        pilot = self._pilot
        if pilot is not None and self._is_armed[-1] and pilot.trajectory is not self._plan:
            self._plan = pilot.trajectory
            self._plans.append(planned_leg(plant.time_us * 1e-6, self._plan))

    def story(self, ending: str) -> FlightStory:
        """Return the story of the flight so far.

        Args:
            ending: Result in a few words, for the title.
        """
        plant, pilot = self._plant, self._pilot
        scene, airframe = plant.world.scene, plant.world.airframe
        known = FlightStory(
            scene=scene,
            airframe=airframe,
            title=title_of(scene, airframe, ending),
            track=self._track(),
            movers=self._mover_paths(),
        )
        if pilot is None:
            return known
        landing = pilot.landing_map
        return replace(
            known,
            phases=(
                (0.0, self._first_phase),
                *((t.time_us * 1e-6, t.target.value) for t in pilot.transitions),
            ),
            plans=tuple(self._plans),
            area=pilot.area,
            touchdown_enu_m=pilot.touchdown_enu_m,
            landing=None if landing is None else LandingLayers.from_map(landing),
        )

    def _track(self) -> Track:
        true_m, est_m, ref_m = (
            np.array([row[column] for row in self._rows]).reshape(-1, 3) for column in range(3)
        )
        is_armed = np.array(self._is_armed, dtype=bool)
        return Track(
            time_s=np.array(self._times_us) * 1e-6,
            true_enu_m=true_m,
            # Fields are all zero until the estimator is aligned, and until there is a set point.
            est_enu_m=np.where(np.any(est_m, axis=1, keepdims=True), est_m, np.nan),
            ref_enu_m=np.where(
                is_armed[:, None] & np.any(ref_m, axis=1, keepdims=True), ref_m, np.nan
            ),
        )

    def _mover_paths(self) -> tuple[MoverPath, ...]:
        obstacles = self._plant.world.obstacles
        names = [mover_name(index, obstacles) for index in range(len(obstacles))]
        names += [vehicle_name(other.world.number) for other in self._other_plants]
        positions = np.array(self._movers).reshape(len(self._movers), len(names), 3)
        paths = [
            MoverPath(name=name, points_enu_m=positions[:, index])
            for index, name in enumerate(names)
        ]
        return tuple(sorted(paths, key=lambda path: path.name))


def planned_leg(time_s: float, plan: Trajectory) -> PlannedLeg:
    """Return points along a plan, evenly in time and including its end.

    Args:
        time_s: Time at which the plan takes effect.
        plan: Plan of the pilot.
    """
    n_steps = max(1, round(plan.duration_s / PLAN_STEP_S))
    times_s = np.linspace(0.0, plan.duration_s, n_steps + 1)
    points_enu_m = plan.positions(times_s)
    return PlannedLeg(time_s=time_s, points_enu_m=points_enu_m, step_s=plan.duration_s / n_steps)
