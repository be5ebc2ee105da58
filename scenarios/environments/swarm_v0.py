"""`AeroScene/Swarm-v0`: several vehicles in one world, by PettingZoo's parallel interface.

from scenarios.environments import swarm_v0

env = swarm_v0.parallel_env(vehicles=4, scene="42")
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from jaxtyping import Float

try:
    from pettingzoo import ParallelEnv
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "the swarm needs pettingzoo, which is not installed; pip install 'aeroscene[rl]'",
        name="pettingzoo",
    ) from error

from aeroscene.scene import Scene
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.environments.batch import Batch
from scenarios.environments.cfg import EnvironmentCfg, EnvironmentInputError
from scenarios.environments.interface.actions import N_ACTIONS, checked_actions
from scenarios.environments.interface.observations import Observation, take
from scenarios.environments.interface.pictures import RENDER_MODES, Picture, checked_render_mode
from scenarios.environments.tasks.swarm import Swarm

_MOST_VEHICLES = 16
_Step = tuple[
    dict[str, Observation],
    dict[str, float],
    dict[str, bool],
    dict[str, bool],
    dict[str, dict[str, Any]],
]


class AeroSceneSwarm(ParallelEnv[str, Observation, np.ndarray]):
    """Vehicles that share one world and meet in it; `parallel_env` makes one.

    Agents are `vehicle_1`, `vehicle_2` and so on. An agent that touches anything has ended: its
    rotors stop, and it falls. The others fly on around it.
    """

    metadata = {  # noqa: RUF012 - PettingZoo's
        "name": "AeroScene/Swarm-v0",
        "render_modes": RENDER_MODES,
    }

    def __init__(
        self,
        vehicles: int | Sequence[str] = 4,
        scene: str | Scene = "field",
        cfg: EnvironmentCfg | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Build the world.

        Args:
            vehicles: Number of vehicles of the configured airframe, or the airframe of each; all
                have as many rotors.
            scene: Scene, or its name as the command line takes it.
            cfg: Configuration; its observations are each vehicle's own.
            render_mode: "rgb_array" if `render` shall return pictures.

        Raises:
            EnvironmentInputError: If the configuration, the vehicles or the mode are not valid.
            SceneError: If there is no such scene.
            AirframeError: If there is no such vehicle.
            WorldError: If the scene's start has no room for so many.
        """
        self.render_mode = checked_render_mode(render_mode)
        self._cfg = cfg = cfg or EnvironmentCfg()
        # Films of the environment run as fast as it does.
        self.metadata = {**self.metadata, "render_fps": cfg.action_hz}
        airframes = _airframes(vehicles, cfg)
        n = len(airframes)
        self._batch = Batch(Swarm(n), [scene], cfg, airframes=airframes)
        self.possible_agents = [f"vehicle_{i + 1}" for i in range(n)]
        self.agents: list[str] = []
        self.observation_spaces = dict.fromkeys(self.possible_agents, self._batch.observer.space)
        self.action_spaces = {
            agent: spaces.Box(-1.0, 1.0, (N_ACTIONS,), dtype=np.float32)
            for agent in self.possible_agents
        }
        self._is_seeded = False

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """The space of an agent's observations: its own numbers, then the others in order."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of an agent's actions, four numbers of -1 to 1."""
        return self.action_spaces[agent]

    @property
    def history(self) -> np.ndarray:
        """The last step of each vehicle, `flightsim.plant.record.HISTORY_DTYPE` (n, k)."""
        return self._batch.history

    def reset(
        self,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - PettingZoo passes them; none are
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin the next episode, the first one of a seed if there is one.

        Raises:
            EnvironmentInputError: If the scene has no place for it.
        """
        if seed is not None or not self._is_seeded:
            # Without a seed the first episode is random; PettingZoo keeps no generator for
            # environments.
            fresh = int(np.random.default_rng().integers(2**31)) if seed is None else seed
            self._batch.seed(0, fresh)
            self._is_seeded = True
        self._batch.begin([0])
        self.agents = self.possible_agents[:]
        return self._observe(self.agents), {agent: {} for agent in self.agents}

    def step(self, actions: Mapping[str, np.ndarray]) -> _Step:
        """Advance by a step; `info` has the distance from the target, at the end the verdict.

        Raises:
            EnvironmentInputError: If an agent that flies has no action, or not a valid one.
            PhysicsDivergedError: If the physics engine had to give the state up.
        """
        flying = self.agents
        if not flying:
            raise EnvironmentInputError("step: no agent flies; only reset() is valid")
        step = self._batch.step(self._checked(actions))
        infos: dict[str, dict[str, Any]] = {}
        for agent in flying:
            i = self._index(agent)
            infos[agent] = {"distance_m": float(step.distance_m[i])}
            if i in step.outcomes:
                infos[agent] |= step.outcomes[i].to_info()
        # Ended agents are in this step's results, and in none after it.
        self.agents = [agent for agent in flying if self._index(agent) not in step.outcomes]
        return (
            self._observe(flying),
            {agent: float(step.reward[self._index(agent)]) for agent in flying},
            {agent: bool(step.is_terminated[self._index(agent)]) for agent in flying},
            {agent: bool(step.is_truncated[self._index(agent)]) for agent in flying},
            infos,
        )

    def render(self) -> Picture | None:
        """Return all vehicles in one picture, (480, 640, 3) uint8; None without a mode.

        Raises:
            EnvironmentInputError: If no episode has begun.
        """
        return None if self.render_mode is None else self._batch.picture(0)

    def close(self) -> None:
        """Free the world's resources: threads and renderers."""
        self._batch.close()

    def _index(self, agent: str) -> int:
        return self.possible_agents.index(agent)

    def _observe(self, agents: Sequence[str]) -> dict[str, Observation]:
        observations = self._batch.observe()
        return {agent: take(observations, self._index(agent)) for agent in agents}

    def _checked(self, actions: Mapping[str, np.ndarray]) -> Float[np.ndarray, "n 4"]:
        """Return the actions of the agents that fly; zero for the others."""
        # Vehicles that have ended still have rows in the batch; their actions do nothing.
        given = np.zeros((len(self.possible_agents), N_ACTIONS))
        for agent in self.agents:
            if agent not in actions:
                raise EnvironmentInputError(
                    f"actions: {agent} has none; one for each of {', '.join(self.agents)} is valid"
                )
            given[self._index(agent)] = checked_actions(actions[agent], (N_ACTIONS,))
        return given


parallel_env = AeroSceneSwarm
"""Maker of `AeroScene/Swarm-v0`, under the name that PettingZoo's environments use for it."""


def _airframes(vehicles: int | Sequence[str], cfg: EnvironmentCfg) -> list[Airframe]:
    names = [cfg.vehicle] * vehicles if isinstance(vehicles, int) else list(vehicles)
    # A single name would be read as a list of letters.
    if isinstance(vehicles, str) or not 2 <= len(names) <= _MOST_VEHICLES:
        raise EnvironmentInputError(
            f"vehicles = {vehicles!r}: 2 to {_MOST_VEHICLES}, or as many airframes, are valid"
        )
    airframes = [airframe_by_name(name) for name in names]
    # The arrays of a batch have one number of rotors.
    if len({len(airframe.quadrotor.rotors) for airframe in airframes}) > 1:
        raise EnvironmentInputError(
            f"vehicles = {vehicles!r}: airframes with the same number of rotors are valid"
        )
    return airframes
