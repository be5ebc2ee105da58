"""A policy aboard a vehicle: it observes as in its environment, and steers by MAVLink."""

from __future__ import annotations

import numpy as np

from autonomy.types import Vector3
from flightsim.mavlink.client import MavlinkClient, Telemetry
from flightsim.plant import Plant
from flightsim.simulator import TICK_US
from scenarios.environments.interface.actions import N_ACTIONS, ActionScale
from scenarios.environments.interface.by_mavlink import send_command
from scenarios.environments.interface.observations import Observer, take
from scenarios.policies.policy import Policy


class Agent:
    """Flies a vehicle by a policy; call `update` after each tick.

    The parts of its observation come from where they came in training: a true state from the
    vehicle itself, sensors from its sensors. Only an estimated state comes by MAVLink, because the
    autopilot that flies may be any.
    """

    def __init__(self, policy: Policy, client: MavlinkClient, plant: Plant) -> None:
        """Board a vehicle.

        Args:
            policy: The policy.
            client: Companion, whose `update` somebody else calls.
            plant: The vehicle.
        """
        self._policy, self._client = policy, client
        self._cfg = cfg = policy.description.cfg
        self._n_ticks = ticks_per_action(cfg.action_hz)
        self._scale = ActionScale([plant.world.airframe], cfg.action)
        self._estimate = [np.zeros((1, n)) for n in (3, 3, 4, 3)]
        self._observer = Observer(
            _Watched(plant), cfg.observation, n_threads=1, estimate=self._estimate
        )
        self._last_action = np.zeros((1, N_ACTIONS))
        self._n_to_wait = 0
        self.update_estimate()

    @property
    def position_enu_m(self) -> Vector3:
        """Position of the vehicle as the policy knows it."""
        x, y, z = self._observer.position_enu_m[0].tolist()
        return (x, y, z)

    def update_estimate(self) -> None:
        """Take over the latest telemetry."""
        t: Telemetry = self._client.telemetry
        state = (t.position_enu_m, t.velocity_enu_mps, t.quat_wxyz, t.angular_rate_flu_radps)
        for array, values in zip(self._estimate, state, strict=True):
            array[0] = values

    def update(self, target_enu_m: Vector3) -> None:
        """Act, if the next action is due.

        Args:
            target_enu_m: Target of the policy's task.

        Raises:
            EnvironmentInputError: If the policy's answer is no action.
        """
        self.update_estimate()
        if self._n_to_wait == 0:
            self._n_to_wait = self._n_ticks
            target = np.array([target_enu_m])
            seen = take(self._observer.observe(target, self._last_action), 0)
            self._last_action[0] = self._policy.action(seen)
            observer = self._observer
            commands = self._scale.commands(
                self._last_action, observer.position_enu_m, observer.quat_wxyz
            )
            send_command(self._client, self._cfg.action, commands)
        self._n_to_wait -= 1

    def close(self) -> None:
        """End the threads of its images."""
        self._observer.close()


def ticks_per_action(action_hz: int) -> int:
    """Return the number of ticks of an autopilot's loop between two actions.

    Args:
        action_hz: Rate of the actions; up to that of the loop.
    """
    return 1_000_000 // TICK_US // action_hz


class _Watched:
    """One plant as an observer sees a fleet."""

    n_together = 1

    def __init__(self, plant: Plant) -> None:
        self.worlds = [plant.world]
        self.records, self.history = plant.records, plant.history[None]
