"""Many worlds as a Gymnasium vector environment, advanced in one compiled call.

Gymnasium's own vector environments step one world after the other, or run a process for each. Here
all worlds are rows of one batch, and threads share the physics.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from aeroscene.scene import Scene
from scenarios.environments.autopilots import AutopilotCfg
from scenarios.environments.batch import Batch
from scenarios.environments.cfg import EnvironmentCfg, EnvironmentInputError
from scenarios.environments.episodes.ending import Outcome
from scenarios.environments.interface.actions import N_ACTIONS, checked_actions
from scenarios.environments.interface.observations import Observation, take
from scenarios.environments.interface.pictures import RENDER_MODES, Picture, checked_render_mode
from scenarios.environments.single import ACTION_SPACE, refuse_options
from scenarios.environments.tasks import task_by_name


class AeroSceneVectorEnv(VectorEnv[Any, np.ndarray, np.ndarray]):
    """Vehicles in worlds of their own; `gymnasium.make_vec("AeroScene/Hover-v0", 64)` makes it.

    World i has the scene with the number i, beginning again after the last one, and after
    `reset(seed=s)` it does the same as `AeroSceneEnv` in this scene after `reset(seed=s + i)`. The
    step that ends an episode begins the next one. `final_obs` and `final_info` of its `info` hold
    the end.
    """

    metadata = {  # noqa: RUF012 - Gymnasium declares it
        "render_modes": RENDER_MODES,
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        scenes: Sequence[str | Scene] = ("field",),
        cfg: EnvironmentCfg | None = None,
        n_threads: int | None = None,
        render_mode: str | None = None,
        autopilot: AutopilotCfg | None = None,
    ) -> None:
        """Build the worlds.

        Args:
            task: hover, navigation or landing.
            num_envs: Number of worlds.
            scenes: Scenes, or their names as the command line takes them.
            cfg: Configuration.
            n_threads: Threads that advance the worlds; None takes one for each core.
            render_mode: "rgb_array" if `render` shall return pictures.
            autopilot: Autopilot that follows the actions as MAVLink setpoints; None for none.

        Raises:
            EnvironmentInputError: If the configuration or the mode is not valid.
            SceneError: If there is no such scene.
            AirframeError: If there is no such vehicle.
        """
        if not isinstance(num_envs, int) or num_envs < 1:
            raise EnvironmentInputError(f"num_envs = {num_envs!r}: 1 or more are valid")
        if isinstance(scenes, (str, Scene)) or not len(scenes):
            raise EnvironmentInputError(
                f'scenes = {scenes!r}: a sequence such as ("42", "field") is valid'
            )
        self.num_envs = num_envs
        self.render_mode = checked_render_mode(render_mode)
        # Scenes by turns, so that any number of worlds uses all of them.
        around = [scenes[i % len(scenes)] for i in range(num_envs)]
        self._batch = Batch(task_by_name(task), around, cfg, n_threads, autopilot=autopilot)
        # Films of the environments run as fast as these do.
        self.metadata = {**self.metadata, "render_fps": self._batch.action_hz}
        self.single_observation_space = self._batch.observer.space
        self.single_action_space = ACTION_SPACE
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._is_seeded = False

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Begin the next episode of each world, the first one of its seed if there is one.

        Args:
            seed: s for the seeds s, s + 1 and so on, or a list of seeds.
            options: None; there are no options.

        Raises:
            EnvironmentInputError: If there are options, too many or too few seeds, or a scene has
                no place for the task.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        refuse_options(options)
        for i, given in enumerate(self._seeds(seed)):
            if given is not None:
                self._batch.seed(i, given)
        self._batch.begin(range(self.num_envs))
        self._is_seeded = True
        return self._batch.observe(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Advance all worlds by a step; `info` has the distances from the targets.

        Raises:
            EnvironmentInputError: If the actions have another shape or are not finite.
        """
        step = self._batch.step(checked_actions(actions, (self.num_envs, N_ACTIONS)))
        observations = self._batch.observe()
        info: dict[str, Any] = {"distance_m": step.distance_m}
        # The last observations go into `info`; then the next episodes begin, and only their images
        # are taken anew.
        if step.outcomes:
            info |= self._ends(observations, step.outcomes)
            ended = list(step.outcomes)
            self._batch.begin(ended)
            observations = self._batch.observe((observations, ended))
        return observations, step.reward, step.is_terminated, step.is_truncated, info

    def render(self) -> tuple[Picture, ...] | None:
        """Return a picture of each world's vehicle, (480, 640, 3) uint8; None without a mode.

        Raises:
            EnvironmentInputError: If no episode has begun.
        """
        return (
            None
            if self.render_mode is None
            else tuple(self._batch.picture(i) for i in range(self.num_envs))
        )

    def close_extras(self, **_kwargs: Any) -> None:
        """End the threads and close the renderers."""
        self._batch.close()

    def _ends(self, observations: Observation, outcomes: Mapping[int, Outcome]) -> dict[str, Any]:
        """The part of `info` for episodes that are over, equal to repeated calls of `_add_info`."""
        ended, infos = list(outcomes), [outcome.to_info() for outcome in outcomes.values()]
        is_over = np.zeros(self.num_envs, dtype=bool)
        is_over[ended] = True
        final_obs = np.full(self.num_envs, None, dtype=object)
        for i in ended:
            final_obs[i] = take(observations, i)
        final_info: dict[str, np.ndarray] = {}
        for name, value in infos[0].items():
            is_text = isinstance(value, str)
            # Worlds that go on have a placeholder; `_name` says which entries count.
            values = np.full(
                self.num_envs, None if is_text else 0, object if is_text else type(value)
            )
            values[ended] = [info[name] for info in infos]
            final_info |= {name: values, f"_{name}": is_over.copy()}
        return {
            "final_obs": final_obs,
            "_final_obs": is_over,
            "final_info": final_info,
            "_final_info": is_over.copy(),
        }

    def _seeds(self, seed: int | list[int | None] | None) -> Sequence[int | None]:
        if isinstance(seed, int):
            return [seed + i for i in range(self.num_envs)]
        # Gymnasium's rule: without a seed each world goes on with its own stream.
        if seed is None and self._is_seeded:
            return [None] * self.num_envs
        if seed is None:
            return self.np_random.integers(2**31, size=self.num_envs).tolist()
        if len(seed) != self.num_envs:
            raise EnvironmentInputError(
                f"seed: {len(seed)} numbers for {self.num_envs} worlds; one for each is valid"
            )
        return seed
