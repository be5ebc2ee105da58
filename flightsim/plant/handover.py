"""Handover of a plant to a flight stack that is not ours, which commands the rotors at every tick.

PX4 and ArduPilot run their own estimator and controller in lockstep with the physics, once for
every control tick and not once for 20 ms. The plant then advances tick by tick, and its own
estimator and controller rest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from autonomy.types import ControlLevel, State
from flightsim.plant.kernel import advance
from flightsim.plant.memory import PlantMemory

# The type checker cannot read the signature of a compiled function.
_advance: Callable[..., None] = advance
RotorSpeeds = tuple[float, ...]


class Handover:
    """Rotor commands and estimate of a plant whose own estimator and controller rest."""

    def __init__(self, memory: PlantMemory, drive: Callable[[], None]) -> None:
        """Take a plant over; see `Plant.hand_over`.

        Args:
            memory: Memory of the plant.
            drive: Called before each control tick. It reads the truth and the sensors, and
                commands.
        """
        self._drive = drive
        self._memory = memory
        self._counter = np.zeros(1, np.int64)
        record = memory.plant
        self._engine: np.void = record["engine"]
        self._controller: np.void = record["controller"]
        self._filter: np.void = record["filter"]
        self._setpoint: np.void = record["setpoint"]
        self._engine["ticks_per_advance"] = 1
        self._filter["n_align"] = np.iinfo(np.int64).max  # so the estimator never starts

    def advance(self, end_tick: Callable[[], None]) -> int:
        """Advance by the ticks of the history, one at a time.

        Args:
            end_tick: Called after each tick.

        Returns:
            Number of ticks in which the vehicle touched something.
        """
        history, n_touching = self._memory.history, 0
        for i in range(len(history)):
            self._drive()
            # Each call writes one row, at the place that the pointer names.
            self._engine["history_address"] = history[i:].ctypes.data
            self._counter[0] = 0
            _advance(self._memory.plants.reshape(1, 1), self._counter)
            n_touching += int(self._engine["contact_ticks"])
            end_tick()
        return n_touching

    def command_rotors(self, speeds_radps: RotorSpeeds | None) -> None:
        """Command the speeds of the rotors from the next tick on.

        Args:
            speeds_radps: Speed of each rotor; None cuts the power.
        """
        if speeds_radps is None:
            self._controller["given_speed_radps"] = 0.0
            self._setpoint["level"] = ControlLevel.OFF
        else:
            self._controller["given_speed_radps"][: len(speeds_radps)] = speeds_radps
            self._setpoint["level"] = ControlLevel.ROTORS

    def take_estimate(self, state: State) -> None:
        """Use the state that the flight stack believes as the vehicle's estimate.

        The plant's own filter rests, so recordings and pilots see this one.

        Args:
            state: Estimate of the flight stack.
        """
        self._filter["position_enu_m"] = state.position_enu_m
        self._filter["velocity_enu_mps"] = state.velocity_enu_mps
        self._filter["quat_wxyz"] = state.quat_wxyz
        self._filter["angular_rate_flu_radps"] = state.angular_rate_flu_radps
