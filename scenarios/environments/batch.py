"""Worlds of one task, stepped together: the common basis of all environments.

A single environment, a vector environment and a swarm differ only in their interface. One batch of
worlds by vehicles serves all of them, so that physics, actions, observations and verdicts exist
once. Everything is an array over vehicles, because a call of Python for each vehicle would take
longer than its physics.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from flightsim.draws import generator
from flightsim.plant import Fleet
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world
from scenarios.environments.autopilots import AutopilotCfg, AutopilotFleet, OffboardActuation
from scenarios.environments.cfg import EnvironmentCfg, EnvironmentInputError
from scenarios.environments.episodes.draws import Draws, draw_conditions
from scenarios.environments.episodes.ending import Outcome, judge_episode
from scenarios.environments.episodes.flights import Flights
from scenarios.environments.episodes.place import Place
from scenarios.environments.interface.actions import Actuation, check_motors
from scenarios.environments.interface.latency import ActionQueue
from scenarios.environments.interface.observations import N_NOISES, Observation, Observer
from scenarios.environments.interface.pictures import Photographer, Picture
from scenarios.environments.tasks import Situation, Start, Task
from scenarios.trials.figures import is_still, rotors_turn
from scenarios.trials.limits import LIMITS


@dataclass(frozen=True, eq=False)
class Step:
    """Result of a step, for n vehicles."""

    reward: Float[np.ndarray, " n"]
    is_terminated: Bool[np.ndarray, " n"]
    is_truncated: Bool[np.ndarray, " n"]
    distance_m: Float[np.ndarray, " n"]
    """Distance from the target."""
    outcomes: Mapping[int, Outcome]
    """Outcomes of the episodes that are over, by the vehicle's number."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Episode:
    """A vehicle's part of an episode that has begun."""

    start: Start
    drawn: Draws
    rng: np.random.Generator
    """Generator of its world, shared by the vehicles in it."""


class Batch:
    """Worlds in which a task is done again and again, by one vehicle or several in each.

    A world's course depends only on its scene, its seed and its actions, bit for bit: neither on
    the other worlds nor on the number of threads. Arrays have a row for each of n vehicles: those
    of the first world, then those of the second, and so on. A vehicle whose episode is over stops
    its rotors until the next one begins in its world.

    Attributes:
        observer: Builder of the observations; `observe` asks it.
    """

    def __init__(
        self,
        task: Task,
        scenes: Sequence[str | Scene],
        cfg: EnvironmentCfg | None = None,
        n_threads: int | None = None,
        airframes: Sequence[Airframe] = (),
        autopilot: AutopilotCfg | None = None,
    ) -> None:
        """Build the worlds.

        Args:
            task: Task of every world.
            scenes: Scene of each world; one that is named twice is built once.
            cfg: Configuration.
            n_threads: Threads that advance the worlds; None takes one for each core.
            airframes: Vehicles of each world, with as many rotors each; by default the configured
                one alone.
            autopilot: Autopilot that flies each vehicle; None lets actions reach the plants' own
                controllers.

        Raises:
            EnvironmentInputError: If the configuration is not valid.
            SceneError: If there is no such scene.
            AirframeError: If there is no such vehicle.
            WorldError: If a scene's start has no room for so many.
        """
        self._cfg = cfg = _checked_cfg(cfg, n_threads)
        self._task = task
        airframes = airframes or (airframe_by_name(cfg.vehicle),)
        for airframe in airframes:
            check_motors(cfg.action, airframe)
        self._places, worlds = _built(scenes, airframes)
        self._actuation: Actuation | OffboardActuation
        if autopilot is None:
            fleet = Fleet(worlds, [cfg.plant_cfg(0)] * len(worlds), n_threads=n_threads)
            self._actuation = Actuation(fleet, cfg.action)
        else:
            if autopilot.name != "builtin" and task.settles:
                # Its episodes begin above an area, and such a stack flies to its start without map.
                raise EnvironmentInputError(
                    f"task = {task.name!r} with autopilot {autopilot.name!r}: its episodes begin "
                    "too far from the start; hover, navigation are valid"
                )
            flown = AutopilotFleet(worlds, cfg, autopilot)
            self._actuation = OffboardActuation(flown, cfg)
            # It has all members of a fleet that are used here and below.
            fleet = cast("Fleet", flown)
        self._fleet, n = fleet, len(fleet)
        self.observer = Observer(fleet, cfg.observation, n_threads)
        self._queue = ActionQueue(n, cfg.longest_latency)
        self._step_s = 1.0 / cfg.action_hz
        self._flights = Flights(fleet, self._step_s)
        self._photographer = Photographer(fleet, self._step_s)
        self._longest_s = cfg.episode_s or task.episode_s
        self._seeds, self._n_begun = [0] * len(worlds), [0] * len(worlds)
        self._episodes: dict[int, _Episode] = {}
        self._begun_s, self._is_flying = np.zeros(n), np.zeros(n, bool)
        # Without noise no normals are drawn.
        self._noise = np.zeros((n, N_NOISES)) if cfg.randomisation.noise > 0.0 else None
        self._now = Situation(fleet, task.near_m, self._step_s)

    def __len__(self) -> int:
        return len(self._places)

    @property
    def action_hz(self) -> int:
        """Number of steps in a simulated second."""
        return self._cfg.action_hz

    @property
    def history(self) -> np.ndarray:
        """The last step of each vehicle, `flightsim.plant.record.HISTORY_DTYPE` (n, k)."""
        return self._fleet.history

    def seed(self, world: int, seed: int) -> None:
        """Let a world's next episode be the first of a seed."""
        self._seeds[world], self._n_begun[world] = seed, 0

    def begin(self, worlds: Sequence[int]) -> None:
        """Begin the next episodes of worlds: hold vehicles until they are aligned, then let go.

        Raises:
            EnvironmentInputError: If a scene has no place for it.
        """
        fleet, begun = self._fleet, [self._hold(world) for world in worlds]
        # One call aligns all vehicles that are held.
        fleet.align(worlds)
        if self._cfg.observation.has_sensors:
            fleet.share(worlds, fleet.advance_one)
        for world, episodes in zip(worlds, begun, strict=True):
            fleet.release(world)
            self._n_begun[world] += 1
            vehicles = fleet.vehicles_of(world)
            for i, episode in zip(vehicles, episodes, strict=True):
                self._let_go(i, episode)
            self._draw_noise(vehicles)

    def _hold(self, world: int) -> list[_Episode]:
        """Draw the next episode of each vehicle of a world, and hold it at its start."""
        place, cfg, fleet = self._places[world], self._cfg, self._fleet
        # The number of the episode is part of the stream: each one draws anew.
        stream = ("environment", self._task.name, self._n_begun[world])
        rng = generator(self._seeds[world], place.world.scene.scene_id, *stream)
        starts = self._task.draw(place, rng)
        n_rotors = fleet.motor_speeds_radps.shape[1]
        drawn = [
            draw_conditions(rng, cfg.randomisation, cfg.longest_latency, n_rotors) for _ in starts
        ]
        fleet.restart(
            world,
            # One wind blows in one world.
            drawn[0].plant_seed,
            drawn[0].wind,
            held_at=[(start.position_enu_m, start.quat_wxyz) for start in starts],
            mass_shares=[each.mass_share for each in drawn] if cfg.randomisation.mass > 0.0 else (),
        )
        return [
            _Episode(start=start, drawn=each, rng=rng)
            for start, each in zip(starts, drawn, strict=True)
        ]

    def _let_go(self, index: int, episode: _Episode) -> None:
        """Begin a vehicle's part of an episode."""
        start, drawn = episode.start, episode.drawn
        rotor_shares = self._fleet.records["rotors"]["effectiveness"][index]
        rotor_shares[: len(drawn.rotor_shares)] = drawn.rotor_shares
        self._queue.restart(index, drawn.latency)
        self._flights.begin(index)
        self._photographer.begin(index)
        self._episodes[index], self._is_flying[index] = episode, True
        # Alignment took simulated time, which does not count as part of the episode.
        self._begun_s[index] = self._fleet.time_s[index]
        self._now.begin(index, start.target_enu_m)

    def observe(self, before: tuple[Observation, Sequence[int]] | None = None) -> Observation:
        """Return the observations of all vehicles now; for `before` see `Observer.observe`."""
        now, queue = self._now, self._queue
        return self.observer.observe(now.target_enu_m, queue.latest, self._noise, before)

    def step(self, actions: Float[np.ndarray, "n 4"]) -> Step:
        """Advance all worlds by a step.

        Args:
            actions: Checked actions, shape (n, 4), -1 to 1.

        Raises:
            EnvironmentInputError: If no episode has begun.
            PhysicsDivergedError: If the physics engine had to give a state up.
        """
        self._require_episodes("step")
        # The distance before the step, for rewards of progress.
        now, before_m = self._now, self._now.distance_m.copy()
        knower = self.observer
        self._actuation.apply(self._queue.delayed(actions), knower.position_enu_m, knower.quat_wxyz)
        if not self._is_flying.all():
            self._actuation.stop(~self._is_flying)
        self._fleet.advance()
        now.look()
        self._flights.take(self._is_flying, now.is_touching)
        reward = self._task.reward(now, before_m, self._step_s)
        is_over = self._task.is_over(now)
        seconds = self._fleet.time_s - self._begun_s
        # Within rounding of sums of steps; an end of the task goes first.
        is_time_up = (seconds >= self._longest_s - 1e-6) & ~is_over
        outcomes: dict[int, Outcome] = {}
        has_ended = self._is_flying & (is_over | is_time_up)
        if has_ended.any():
            outcomes = self._end(np.flatnonzero(has_ended).tolist(), seconds, is_time_up)
        for i, outcome in outcomes.items():
            is_success, is_late = bool(outcome.judgement.success), bool(is_time_up[i])
            reward[i] += self._task.end_reward(is_success=is_success, is_time_up=is_late)
        self._draw_noise(range(len(self._fleet)))
        return Step(reward, is_over, is_time_up, now.distance_m.copy(), outcomes)

    def picture(self, world: int) -> Picture:
        """A picture of a world's vehicle, from behind and above, or of its vehicles together.

        Raises:
            EnvironmentInputError: If no episode has begun.
        """
        self._require_episodes("render")
        vehicles = self._fleet.vehicles_of(world)
        if len(vehicles) > 1:
            return self._photographer.together(vehicles)
        return self._photographer.behind(vehicles[0])

    def close(self) -> None:
        """End the threads and close the renderers."""
        self._photographer.close()
        self.observer.close()
        self._fleet.close()

    def _require_episodes(self, what: str) -> None:
        if not self._episodes:
            raise EnvironmentInputError(f"{what}: before the first episode only reset() is valid")

    def _end(
        self, ended: Sequence[int], seconds: np.ndarray, is_time_up: np.ndarray
    ) -> dict[int, Outcome]:
        """Judge episodes that are over; a task with `settles` waits for rest first."""
        rest: dict[int, list[np.ndarray]] = {}
        if self._task.settles:
            touching = [i for i in ended if self._now.touch_s[i] > 0.0]
            # Such a task has one vehicle in each world: a vehicle's number is its world's.
            self._fleet.share(touching, lambda i: rest.update({i: self._settle(i)}))
        return {
            i: self._judge(i, rest.get(i, []), float(seconds[i]), is_time_up=bool(is_time_up[i]))
            for i in ended
        }

    def _judge(
        self, index: int, rest: Sequence[np.ndarray], seconds: float, *, is_time_up: bool
    ) -> Outcome:
        """Judge an episode that is over; `rest` has the rows in which the vehicle came to rest."""
        self._is_flying[index] = False
        ending = self._task.ending(self._now, index, seconds, is_time_up=is_time_up)
        history, n_before = self._flights.of(index, rest)
        goal, place = (
            self._episodes[index].start.goal,
            self._places[index // self._fleet.n_together],
        )
        judgement = judge_episode(
            history,
            n_before,
            self._fleet.worlds[index].airframe,
            goal,
            ending,
            place.contacts if goal.area is not None else None,
        )
        return Outcome(judgement, seconds)

    def _settle(self, index: int) -> list[np.ndarray]:
        """Stop the rotors, and wait until the vehicle rests; return its rows of that time."""
        fleet, rows, n_still = self._fleet, [], 0
        self._actuation.stop(index)
        for _ in range(round(LIMITS.longest_settle_s / self._step_s)):
            fleet.advance_one(index)
            rows.append(self._flights.last(index))
            n_still = n_still + 1 if is_still(fleet.history[index]) else 0
            is_long_enough = n_still >= round(LIMITS.rest_s / self._step_s)
            last = fleet.history[index, -1:]
            if is_long_enough and not rotors_turn(last, fleet.worlds[index].airframe)[0]:
                break
        return rows

    def _draw_noise(self, vehicles: Iterable[int]) -> None:
        if self._noise is None:
            return
        for i in vehicles:
            episode = self._episodes[i]
            if episode.drawn.noise_level > 0.0:
                normals = episode.rng.standard_normal(N_NOISES)
                self._noise[i] = episode.drawn.noise_level * normals


def _checked_cfg(cfg: EnvironmentCfg | None, n_threads: int | None) -> EnvironmentCfg:
    if cfg is not None and not isinstance(cfg, EnvironmentCfg):
        raise EnvironmentInputError(f"cfg = {cfg!r}: an EnvironmentCfg is valid")
    if n_threads is not None and not (isinstance(n_threads, int) and n_threads >= 1):
        raise EnvironmentInputError(f"n_threads = {n_threads!r}: 1 or more are valid")
    return cfg or EnvironmentCfg()


def _built(
    scenes: Sequence[str | Scene], airframes: Sequence[Airframe]
) -> tuple[list[Place], list[World]]:
    """Return place and world of each scene; a scene that is named twice is built once.

    The place of several vehicles is tested with one alone, the largest, because free air for it
    suffices for all.
    """
    largest = max(airframes, key=lambda airframe: airframe.collision_radius_m)
    built: dict[int | str, tuple[Place, World]] = {}
    for spec in scenes:
        if _key(spec) not in built:
            scene = load_scene(spec) if isinstance(spec, str) else spec
            world = build_world(scene, *airframes)
            alone = world if len(airframes) == 1 else build_world(scene, largest)
            built[_key(spec)] = Place(alone), world
    places, worlds = zip(*(built[_key(spec)] for spec in scenes), strict=True)
    return list(places), list(worlds)


def _key(spec: str | Scene) -> int | str:
    return spec if isinstance(spec, str) else id(spec)
