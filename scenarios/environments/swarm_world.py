"""The world of a swarm: its vehicles, an episode in it, and what each vehicle sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from jaxtyping import Bool, Float

from aeroscene.scene import Scene
from flightsim.draws import generator
from flightsim.plant import Fleet
from flightsim.vehicles.airframe import Airframe
from flightsim.world import build_world
from scenarios.environments.cfg import EnvironmentCfg
from scenarios.environments.episodes.draws import Draws, draw_conditions
from scenarios.environments.episodes.ending import EpisodeLog, Outcome
from scenarios.environments.episodes.place import Place
from scenarios.environments.interface.actions import Actuation
from scenarios.environments.interface.latency import ActionQueue
from scenarios.environments.interface.observations import N_NOISES, Observation, Observer
from scenarios.environments.interface.pictures import Photographer, Picture
from scenarios.environments.tasks.swarm import Swarm
from scenarios.environments.tasks.task import Situation, Start

_MATE_BOUNDS = np.repeat([1000.0, 100.0], 3).astype(np.float32)
"""Bounds of the way to another vehicle and of its velocity relative to one's own."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Flight:
    """A vehicle's part of an episode."""

    start: Start
    drawn: Draws
    log: EpisodeLog


class SwarmWorld:
    """Vehicles in one world, in which episodes begin again and again.

    Attributes:
        task: What they are to do.
        now: Where they are.
        space: Space of one vehicle's observation.
        seconds: Time of the present episode.
    """

    def __init__(self, scene: Scene, airframes: Sequence[Airframe], cfg: EnvironmentCfg) -> None:
        """Build the world.

        Args:
            scene: Scene to fly in.
            airframes: The vehicles, with as many rotors each.
            cfg: Configuration.

        Raises:
            WorldError: If the scene's start has no room for so many.
        """
        self._cfg = cfg
        largest = max(airframes, key=lambda airframe: airframe.collision_radius_m)
        self._place = Place(build_world(scene, largest))
        self._n = n = len(airframes)
        self._fleet = Fleet([build_world(scene, *airframes)], [cfg.plant_cfg(0)], n_threads=1)
        self._observer = Observer(self._fleet, cfg.observation)
        own = self._observer.space
        self._numbers = _numbers_space(own, n)
        self.space: spaces.Space[Any] = self._numbers
        if isinstance(own, spaces.Dict):
            self.space = spaces.Dict({**own.spaces, "numbers": self._numbers})
        self._actuation = Actuation(self._fleet, cfg.action)
        self._queue = ActionQueue(n, cfg.longest_latency)
        self.task = Swarm()
        self._step_s, self._longest_s = 1.0 / cfg.action_hz, cfg.episode_s or self.task.episode_s
        self._photographer = Photographer(self._fleet, self._step_s)
        self.seconds = self._begun_s = 0.0
        self._flights: list[_Flight] = []
        self._noise = np.zeros((n, N_NOISES))
        history = self._fleet.history
        self.now = Situation(
            position_enu_m=history["position_true_enu_m"][:, -1],
            velocity_enu_mps=history["velocity_true_enu_mps"][:, -1],
            rate_flu_radps=history["angular_rate_true_flu_radps"][:, -1],
            target_enu_m=np.zeros((n, 3)),
            distance_m=np.zeros(n),
            near_s=np.zeros(n),
            touch_s=np.zeros(n),
        )

    @property
    def history(self) -> np.ndarray:
        """The last step of each vehicle, `flightsim.plant.record.HISTORY_DTYPE` (n, k)."""
        return self._fleet.history

    @property
    def is_time_up(self) -> bool:
        """Whether the episode has lasted as long as it may."""
        return self.seconds >= self._longest_s - 1e-6

    def begin(self, seed: int, number: int) -> None:
        """Draw an episode of a seed, hold all vehicles until they are aligned, and let go.

        Raises:
            EnvironmentInputError: If the scene has no place for it.
        """
        cfg, fleet, scene_id = self._cfg, self._fleet, self._place.world.scene.scene_id
        self._rng = rng = generator(seed, scene_id, "environment", "swarm", number)
        starts = self.task.draw(self._place, rng, self._n)
        n_rotors = fleet.motor_speeds_radps.shape[1]
        drawn = [
            draw_conditions(rng, cfg.randomisation, cfg.longest_latency, n_rotors) for _ in starts
        ]
        # One wind blows in one world.
        plant_cfg = cfg.plant_cfg(drawn[0].plant_seed, drawn[0].wind)
        fleet.restart(
            0,
            plant_cfg,
            held_at=[(start.position_enu_m, start.quat_wxyz) for start in starts],
            mass_shares=[each.mass_share for each in drawn],
        )
        fleet.align(0)
        if cfg.observation.has_sensors:
            fleet.advance_one(0)
        fleet.release(0)
        now = self.now
        for i, (start, each) in enumerate(zip(starts, drawn, strict=True)):
            fleet.records["rotors"]["effectiveness"][i, :n_rotors] = each.rotor_shares
            self._queue.restart(i, each.latency)
            now.target_enu_m[i] = start.target_enu_m
            now.distance_m[i] = np.linalg.norm(now.target_enu_m[i] - start.position_enu_m)
        now.near_s[:] = now.touch_s[:] = 0.0
        n_bytes = fleet.history[0].nbytes
        self._flights = [
            _Flight(start=start, drawn=each, log=EpisodeLog(i, n_bytes))
            for i, (start, each) in enumerate(zip(starts, drawn, strict=True))
        ]
        self._begun_s = float(fleet.time_s[0])
        self.seconds = 0.0
        self._draw_noise()

    def step(
        self, actions: Float[np.ndarray, "n 4"], is_flying: Bool[np.ndarray, " n"]
    ) -> Float[np.ndarray, " n"]:
        """Go on by a step, and return the rewards, without those of an end.

        Args:
            actions: Checked actions.
            is_flying: Which vehicles fly; the rotors of the others stand still.
        """
        before_m = self.now.distance_m.copy()
        self._actuation.apply(self._queue.delayed(actions), self._observer.position_enu_m)
        for i in np.flatnonzero(~is_flying).tolist():
            self._actuation.stop(i)
        self._fleet.advance()
        rows = self._fleet.history.tobytes()
        for i in np.flatnonzero(is_flying).tolist():
            self._flights[i].log.add(rows)
        self._look()
        self._draw_noise()
        self.seconds = float(self._fleet.time_s[0]) - self._begun_s
        return self.task.reward(self.now, before_m, self._step_s)

    def outcome(self, index: int, *, is_time_up: bool) -> Outcome:
        """Verdict on the episode of one vehicle, which ends now."""
        seconds = self.seconds
        flight, airframe = self._flights[index], self._fleet.worlds[index].airframe
        ending = self.task.ending(self.now, index, seconds, is_time_up=is_time_up)
        return Outcome(flight.log.judge(airframe, flight.start.goal, ending), seconds)

    def observe(self) -> Observation:
        """Observations of all vehicles now, each with its mates as they truly are."""
        now = self.now
        own = self._observer.observe(now.target_enu_m, self._queue.latest, self._noise)
        images = own if isinstance(own, dict) else {"numbers": own}
        numbers = images.get("numbers", np.zeros((self._n, 0), np.float32))
        mates = [_mates(i, now.position_enu_m, now.velocity_enu_mps) for i in range(self._n)]
        numbers = np.concatenate([numbers, mates], axis=1, dtype=np.float32)
        np.clip(numbers, self._numbers.low, self._numbers.high, out=numbers)
        return {**images, "numbers": numbers} if isinstance(own, dict) else numbers

    def picture(self) -> Picture:
        """All vehicles as they are now."""
        return self._photographer.all_together()

    def close(self) -> None:
        """Free what the world holds."""
        self._photographer.close()
        self._observer.close()
        self._fleet.close()

    def _look(self) -> None:
        """Bring the situation up to date."""
        now = self.now
        now.distance_m[:] = np.linalg.norm(now.target_enu_m - now.position_enu_m, axis=1)
        is_touching = np.any(self._fleet.history["is_touching"] > 0, axis=1)
        is_near = np.asarray(now.distance_m <= self.task.near_m)
        now.near_s[:] = np.where(is_near, now.near_s + self._step_s, 0.0)
        now.touch_s[:] = np.where(is_touching, now.touch_s + self._step_s, 0.0)

    def _draw_noise(self) -> None:
        for i, flight in enumerate(self._flights):
            if flight.drawn.noise_level > 0.0:
                self._noise[i] = flight.drawn.noise_level * self._rng.standard_normal(N_NOISES)


def _numbers_space(own: spaces.Space[Any], n: int) -> spaces.Box:
    """Own numbers, and for each other vehicle the way to it and its relative velocity."""
    numbers = own.spaces.get("numbers") if isinstance(own, spaces.Dict) else own
    most = np.tile(_MATE_BOUNDS, n - 1)
    low, high = -most, most
    if isinstance(numbers, spaces.Box):
        low, high = np.concatenate([numbers.low, low]), np.concatenate([numbers.high, high])
    return spaces.Box(low, high, dtype=np.float32)


def _mates(
    index: int,
    position_enu_m: Float[np.ndarray, "n 3"],
    velocity_enu_mps: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, " k"]:
    """Ways to the other vehicles and their relative velocities, ENU, one after the other."""
    away = np.column_stack(
        [position_enu_m - position_enu_m[index], velocity_enu_mps - velocity_enu_mps[index]]
    )
    return np.delete(away, index, axis=0).ravel()
