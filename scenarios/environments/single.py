"""One world as a Gymnasium environment: a batch of one."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from aeroscene.scene import Scene
from scenarios.environments.autopilots import AutopilotCfg
from scenarios.environments.batch import Batch
from scenarios.environments.cfg import EnvironmentCfg, EnvironmentInputError
from scenarios.environments.interface.actions import N_ACTIONS, checked_actions
from scenarios.environments.interface.observations import take
from scenarios.environments.interface.pictures import RENDER_MODES, Picture, checked_render_mode
from scenarios.environments.tasks import task_by_name

ACTION_SPACE = spaces.Box(-1.0, 1.0, (N_ACTIONS,), dtype=np.float32)


class AeroSceneEnv(gymnasium.Env[Any, np.ndarray]):
    """A vehicle in one world; `gymnasium.make("AeroScene/Hover-v0")` makes one."""

    metadata = {"render_modes": RENDER_MODES}  # noqa: RUF012 - Gymnasium declares it

    def __init__(
        self,
        task: str,
        scene: str | Scene = "field",
        cfg: EnvironmentCfg | None = None,
        render_mode: str | None = None,
        autopilot: AutopilotCfg | None = None,
    ) -> None:
        """Build the world.

        Args:
            task: hover, navigation or landing.
            scene: Scene, or its name as the command line takes it.
            cfg: Configuration.
            render_mode: "rgb_array" if `render` shall return pictures.
            autopilot: Autopilot that follows the actions as MAVLink setpoints; None for none.

        Raises:
            EnvironmentInputError: If the configuration or the mode is not valid.
            SceneError: If there is no such scene.
            AirframeError: If there is no such vehicle.
        """
        self.render_mode = checked_render_mode(render_mode)
        # One world needs no threads.
        self._batch = Batch(task_by_name(task), [scene], cfg, n_threads=1, autopilot=autopilot)
        # Films of the environment run as fast as it does.
        self.metadata = {**self.metadata, "render_fps": self._batch.action_hz}
        self.observation_space = self._batch.observer.space
        self.action_space = ACTION_SPACE
        self._is_seeded = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin the next episode, the first one of a seed if there is one.

        Raises:
            EnvironmentInputError: If there are options, or the scene has no place for the task.
        """
        super().reset(seed=seed)
        refuse_options(options)
        # Without a seed the first reset draws one; later ones go on with the same stream.
        if seed is not None or not self._is_seeded:
            given = int(self.np_random.integers(2**31)) if seed is None else seed
            self._batch.seed(0, given)
            self._is_seeded = True
        self._batch.begin([0])
        return take(self._batch.observe(), 0), {}

    def step(self, action: np.ndarray) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Advance by a step; `info` has the distance from the target, at the end the verdict.

        Raises:
            EnvironmentInputError: If the action has another shape or is not finite.
        """
        step = self._batch.step(checked_actions(action, (N_ACTIONS,))[None])
        info: dict[str, Any] = {"distance_m": float(step.distance_m[0])}
        if step.outcomes:
            info |= step.outcomes[0].to_info()
        is_terminated, is_truncated = bool(step.is_terminated[0]), bool(step.is_truncated[0])
        observation = take(self._batch.observe(), 0)
        return observation, float(step.reward[0]), is_terminated, is_truncated, info

    def render(self) -> Picture | None:
        """Return the vehicle from behind and above, (480, 640, 3) uint8; None without a mode.

        Raises:
            EnvironmentInputError: If no episode has begun.
        """
        return None if self.render_mode is None else self._batch.picture(0)

    def close(self) -> None:
        """Free the world's resources: threads and renderers."""
        self._batch.close()


def refuse_options(options: dict[str, Any] | None) -> None:
    """Refuse options of `reset`, because there are none.

    Raises:
        EnvironmentInputError: If there are any.
    """
    if options:
        raise EnvironmentInputError(f"options = {options!r}: there are none; None is valid")
