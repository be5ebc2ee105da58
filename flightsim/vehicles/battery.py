"""Lithium-polymer battery: open-circuit voltage by charge, sag by current, power by rotor speed.

Notation: V terminal voltage, E open-circuit voltage, R internal resistance, I current, P power.
The load demands power, so V = E - R I and P = V I give V = (E + sqrt(E^2 - 4 R P)) / 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightsim.vehicles.airframe import BatteryParams

# Open-circuit voltage of one LiPo cell at 0, 5, ... 100 % of charge, V: the table that RC battery
# makers publish for balancing by voltage.
_CELL_OCV_V = (
    3.27, 3.61, 3.69, 3.71, 3.73, 3.75, 3.77, 3.79, 3.80, 3.82, 3.84,
    3.85, 3.87, 3.91, 3.95, 3.98, 4.02, 4.08, 4.11, 4.15, 4.20,
)  # fmt: skip
_N_INTERVALS = len(_CELL_OCV_V) - 1
_COULOMB_PER_MAH = 3.6
_NOMINAL_CELL_V = 3.7


class BatteryError(ValueError):
    """The battery's parameters are invalid."""


def cell_voltage_v(state_of_charge: float) -> float:
    """Return the open-circuit voltage of one cell; the charge is clamped to 0 to 1."""
    position = min(max(state_of_charge, 0.0), 1.0) * _N_INTERVALS
    i = min(int(position), _N_INTERVALS - 1)
    return _CELL_OCV_V[i] + (position - i) * (_CELL_OCV_V[i + 1] - _CELL_OCV_V[i])


def watts_per_cubed_speed(params: BatteryParams) -> float:
    """Return the electrical power of the motors over the sum of their cubed speeds, W s^3/rad^3.

    A rotor's power grows with the cube of its speed, so one constant from hover serves all speeds.
    """
    return params.hover_power_w / (params.n_rotors * params.hover_rotor_speed_radps**3)


def amperes_per_cubed_speed(params: BatteryParams) -> float:
    """Return the motors' current over the sum of their cubed speeds, at the nominal voltage."""
    nominal_v = _NOMINAL_CELL_V * params.cells
    return params.hover_power_w / nominal_v / (params.n_rotors * params.hover_rotor_speed_radps**3)


class Battery:
    """State of a pack, in plain floats: about a microsecond per step.

    Raises:
        BatteryError: If the state of charge is outside 0 to 1.
    """

    def __init__(self, params: BatteryParams, state_of_charge: float = 1.0) -> None:
        if not 0.0 <= state_of_charge <= 1.0:
            raise BatteryError(f"state_of_charge {state_of_charge} is outside 0 to 1")
        self.params = params
        self._capacity_c = params.capacity_mah * _COULOMB_PER_MAH
        self._initial_c = state_of_charge * self._capacity_c
        self._used_c = 0.0
        self._watts_per_speed_cubed = watts_per_cubed_speed(params)
        self.current_a = 0.0
        """Current drawn during the last step."""
        self.voltage_v = params.cells * cell_voltage_v(state_of_charge)
        """Voltage at the terminals during the last step."""

    @property
    def consumed_mah(self) -> float:
        """Charge drawn since the start, mAh."""
        return self._used_c / _COULOMB_PER_MAH

    @property
    def remaining(self) -> float:
        """State of charge, 0 to 1."""
        return max(0.0, (self._initial_c - self._used_c) / self._capacity_c)

    def step(self, rotor_speeds_radps: Sequence[float], dt_s: float) -> None:
        """Draw the power of the rotors at these speeds and of the avionics for `dt_s`.

        An empty pack delivers nothing: voltage stays, the motors stop elsewhere for lack of charge.
        A load beyond the pack's greatest power, E^2 / 4R, gets that power.

        Args:
            rotor_speeds_radps: Speed of each rotor; the sign does not matter.
            dt_s: Length of the step.
        """
        cubes = 0.0
        for speed in rotor_speeds_radps:
            cubes += abs(speed * speed * speed)
        power_w = self.params.avionics_power_w + self._watts_per_speed_cubed * cubes
        open_v = self.params.cells * cell_voltage_v(self.remaining)
        # Negative for a load that the pack cannot deliver.
        discriminant = open_v * open_v - 4.0 * self.params.internal_resistance_ohm * power_w
        self.voltage_v = (open_v + math.sqrt(max(0.0, discriminant))) / 2.0
        self.current_a = (open_v - self.voltage_v) / self.params.internal_resistance_ohm
        self._used_c = min(self._initial_c, self._used_c + self.current_a * dt_s)
