"""Worlds of one task, stepped together: what both kinds of environments are made of."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from flightsim.draws import generator
from flightsim.plant import Fleet
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from scenarios.environments.cfg import EnvironmentCfg, EnvironmentInputError
from scenarios.environments.episodes.draws import Draws, draw_conditions
from scenarios.environments.episodes.ending import EpisodeLog, Outcome
from scenarios.environments.episodes.place import Place
from scenarios.environments.interface.actions import Actuation, check_motors
from scenarios.environments.interface.latency import ActionQueue
from scenarios.environments.interface.observations import N_NOISES, Observation, Observer
from scenarios.environments.interface.pictures import Photographer, Picture
from scenarios.environments.tasks import TASKS, Situation, Start
from scenarios.trials.limits import LIMITS


@dataclass(frozen=True, eq=False)
class Step:
    """What a step brought, for n worlds."""

    reward: Float[np.ndarray, " n"]
    is_terminated: Bool[np.ndarray, " n"]
    is_truncated: Bool[np.ndarray, " n"]
    distance_m: Float[np.ndarray, " n"]
    """From the target."""
    outcomes: Mapping[int, Outcome]
    """Of the episodes that are over, by the world's number."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Episode:
    """An episode that has begun."""

    start: Start
    drawn: Draws
    rng: np.random.Generator
    begun_s: float
    """Time of its world at which it began."""
    log: EpisodeLog


class Batch:
    """Worlds in which a task is done again and again.

    What happens in a world follows from its scene, its seed and its actions, bit for bit: neither
    from the other worlds nor from the number of threads.

    Attributes:
        observer: What is seen; `observe` asks it.
    """

    def __init__(
        self,
        task: str,
        scenes: Sequence[str | Scene],
        cfg: EnvironmentCfg | None = None,
        n_threads: int | None = None,
    ) -> None:
        """Build the worlds.

        Args:
            task: Name of the task, see `TASKS`.
            scenes: Scene of each world; one that is named twice is built once.
            cfg: Configuration.
            n_threads: Threads that advance the worlds; None takes one for each core.

        Raises:
            EnvironmentInputError: If the configuration is not valid.
            SceneError: If there is no such scene.
            AirframeError: If there is no such vehicle.
        """
        self._cfg = cfg = _checked_cfg(task, cfg, n_threads)
        self._name, self._task = task, TASKS[task]()
        airframe = airframe_by_name(cfg.vehicle)
        check_motors(cfg.action, airframe)
        self._places = _places(scenes, airframe)
        worlds = [place.world for place in self._places]
        n = len(worlds)
        self._fleet = Fleet(worlds, [cfg.plant_cfg(0)] * n, n_threads=n_threads)
        self.observer = Observer(self._fleet, cfg.observation, n_threads)
        self._actuation = Actuation(self._fleet, cfg.action)
        self._queue = ActionQueue(n, cfg.longest_latency)
        self._step_s = 1.0 / cfg.action_hz
        self._photographer = Photographer(self._fleet, self._step_s)
        self._longest_s = cfg.episode_s or self._task.episode_s
        self._seeds, self._n_begun = [0] * n, [0] * n
        self._episodes: dict[int, _Episode] = {}
        self._noise = np.zeros((n, N_NOISES))
        history = self._fleet.history
        self._now = Situation(
            position_enu_m=history["position_true_enu_m"][:, -1],
            velocity_enu_mps=history["velocity_true_enu_mps"][:, -1],
            rate_flu_radps=history["angular_rate_true_flu_radps"][:, -1],
            target_enu_m=np.zeros((n, 3)),
            distance_m=np.zeros(n),
            near_s=np.zeros(n),
            touch_s=np.zeros(n),
        )

    def __len__(self) -> int:
        return len(self._places)

    @property
    def action_hz(self) -> int:
        """Steps for each simulated second."""
        return self._cfg.action_hz

    @property
    def history(self) -> np.ndarray:
        """The last step of each world, `flightsim.plant.record.HISTORY_DTYPE` (n, k)."""
        return self._fleet.history

    def seed(self, index: int, seed: int) -> None:
        """Let a world's next episode be the first of a seed."""
        self._seeds[index], self._n_begun[index] = seed, 0

    def begin(self, index: int) -> None:
        """Begin a world's next episode.

        Raises:
            EnvironmentInputError: If the scene has no place for it.
        """
        place, cfg, fleet = self._places[index], self._cfg, self._fleet
        stream = ("environment", self._name, self._n_begun[index])
        rng = generator(self._seeds[index], place.world.scene.scene_id, *stream)
        start = self._task.draw(place, rng)
        n_rotors = len(place.world.airframe.quadrotor.rotors)
        drawn = draw_conditions(rng, cfg.randomisation, cfg.longest_latency, n_rotors)
        fleet.restart(
            index,
            cfg.plant_cfg(drawn.plant_seed, drawn.wind),
            held_at=[(start.position_enu_m, start.quat_wxyz)],
            mass_shares=[drawn.mass_share],
        )
        fleet.align(index)
        if cfg.observation.has_sensors:
            fleet.advance_one(index)
        fleet.release(index)
        fleet.records["rotors"]["effectiveness"][index, :n_rotors] = drawn.rotor_shares
        self._queue.restart(index, drawn.latency)
        self._photographer.begin(index)
        self._n_begun[index] += 1
        self._episodes[index] = _Episode(
            start=start,
            drawn=drawn,
            rng=rng,
            begun_s=float(fleet.time_s[index]),
            log=EpisodeLog(index, fleet.history[index].nbytes),
        )
        now = self._now
        now.target_enu_m[index] = start.target_enu_m
        now.near_s[index] = now.touch_s[index] = 0.0
        now.distance_m[index] = math.dist(start.target_enu_m, start.position_enu_m)
        self._draw_noise(index)

    def observe(self, before: tuple[Observation, Sequence[int]] | None = None) -> Observation:
        """Observations of all worlds now; for `before` see `Observer.observe`."""
        now, queue = self._now, self._queue
        return self.observer.observe(now.target_enu_m, queue.latest, self._noise, before)

    def step(self, actions: Float[np.ndarray, "n 4"]) -> Step:
        """Let all worlds go on by a step; an episode that is over goes on only after `begin`.

        Args:
            actions: Checked actions.

        Raises:
            PhysicsDivergedError: If the physics engine had to give a state up.
        """
        now, before_m = self._now, self._now.distance_m.copy()
        self._actuation.apply(self._queue.delayed(actions), self.observer.position_enu_m)
        self._fleet.advance()
        rows = self._fleet.history.tobytes()
        for episode in self._episodes.values():
            episode.log.add(rows)
        self._look()
        reward = self._task.reward(now, before_m, self._step_s)
        is_over = self._task.is_over(now)
        seconds = self._fleet.time_s - [self._episodes[i].begun_s for i in range(len(self))]
        is_time_up = (seconds >= self._longest_s - 1e-6) & ~is_over
        outcomes = {
            i: self._end(i, float(seconds[i]), is_time_up=bool(is_time_up[i]))
            for i in np.flatnonzero(is_over | is_time_up).tolist()
        }
        for i, outcome in outcomes.items():
            is_success = bool(outcome.judgement.success)
            reward[i] += self._task.end_reward(is_success=is_success, is_time_up=is_time_up[i])
        if self._cfg.randomisation.noise > 0.0:
            for i in range(len(self)):
                self._draw_noise(i)
        return Step(reward, is_over, is_time_up, now.distance_m.copy(), outcomes)

    def picture(self, index: int) -> Picture:
        """A world's vehicle as it is now, from behind and above."""
        return self._photographer.behind(index)

    def close(self) -> None:
        """End the threads, and release what has rendered."""
        self._photographer.close()
        self.observer.close()
        self._fleet.close()

    def _look(self) -> None:
        """Bring the situation up to date."""
        now = self._now
        now.distance_m[:] = np.linalg.norm(now.target_enu_m - now.position_enu_m, axis=1)
        is_touching = np.any(self._fleet.history["is_touching"] > 0, axis=1)
        is_near = np.asarray(now.distance_m <= self._task.near_m)
        _count(now.near_s, is_near, self._step_s)
        _count(now.touch_s, is_touching, self._step_s)

    def _end(self, index: int, seconds: float, *, is_time_up: bool) -> Outcome:
        """Judge an episode that is over, in a task that says so after all has come to rest."""
        episode, airframe = self._episodes[index], self._places[index].world.airframe
        ending = self._task.ending(self._now, index, seconds, is_time_up=is_time_up)
        if self._task.settles and self._now.touch_s[index] > 0.0:
            self._settle(index)
        contacts = self._places[index].contacts if episode.start.goal.area is not None else None
        judgement = episode.log.judge(airframe, episode.start.goal, ending, contacts)
        return Outcome(judgement, seconds)

    def _settle(self, index: int) -> None:
        """Stop the rotors, and wait until the vehicle rests."""
        log, airframe = self._episodes[index].log, self._places[index].world.airframe
        n_rest = round(LIMITS.rest_s / self._step_s)
        self._actuation.stop(index)
        for n in range(round(LIMITS.longest_settle_s / self._step_s)):
            if n >= n_rest and log.is_still(airframe, n_rest):
                return
            self._fleet.advance_one(index)
            log.add(self._fleet.history.tobytes())

    def _draw_noise(self, index: int) -> None:
        episode = self._episodes[index]
        if episode.drawn.noise_level > 0.0:
            normals = episode.rng.standard_normal(N_NOISES)
            self._noise[index] = episode.drawn.noise_level * normals


def _count(time_s: np.ndarray, goes_on: np.ndarray, step_s: float) -> None:
    """Add a step to times for which something has gone on, in place."""
    time_s += step_s
    time_s[~goes_on] = 0.0


def _checked_cfg(task: str, cfg: EnvironmentCfg | None, n_threads: int | None) -> EnvironmentCfg:
    if task not in TASKS:
        raise EnvironmentInputError(f"task = {task!r}: {', '.join(TASKS)} are valid")
    if cfg is not None and not isinstance(cfg, EnvironmentCfg):
        raise EnvironmentInputError(f"cfg = {cfg!r}: an EnvironmentCfg is valid")
    if n_threads is not None and not (isinstance(n_threads, int) and n_threads >= 1):
        raise EnvironmentInputError(f"n_threads = {n_threads!r}: 1 or more are valid")
    return cfg or EnvironmentCfg()


def _places(scenes: Sequence[str | Scene], airframe: Airframe) -> list[Place]:
    """Place of each world; a scene that is named twice is built once."""
    places: dict[int | str, Place] = {}
    for spec in scenes:
        if _key(spec) not in places:
            scene = load_scene(spec) if isinstance(spec, str) else spec
            places[_key(spec)] = Place(build_world(scene, airframe))
    return [places[_key(spec)] for spec in scenes]


def _key(spec: str | Scene) -> int | str:
    return spec if isinstance(spec, str) else id(spec)
