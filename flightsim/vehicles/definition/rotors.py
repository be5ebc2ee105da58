"""Rotors of an airframe's file: common values first, then each rotor's place and spin."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from aeroscene.files.toml_fields import Fields
from autonomy.model import RotorParams
from autonomy.model.quadrotor import MAX_ROTORS
from autonomy.types import Vector3

_SPINS = {"ccw": 1, "cw": -1}
_RPM_PER_RADPS = 30.0 / math.pi
_FARTHEST_M = 5.0
_LEAST_GAP = 0.94
"""Least distance of two axes, over the diameter of a rotor, unless one rotor is above the other."""
_LEAST_STACKING = 0.1
"""Least difference of height, over the radius, of rotors one above the other."""
_MOST_MISFIT = 0.15
"""Greatest misfit of a measured thrust or torque, over the greatest one."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RotorSet:
    """All rotors, and their common properties; None takes the default by the vehicle's mass."""

    rotors: tuple[RotorParams, ...]
    radius_m: float
    inertia_kgm2: float | None
    imbalance_kgm: float | None
    friction_nm: float | None


def read_rotors(document: Fields) -> RotorSet:
    """Read `[rotor]` and `[[rotors]]`.

    Args:
        document: The whole file.

    Raises:
        AirframeError: Naming the first field that is wrong.
    """
    shared = document.table("rotor")
    radius_m = shared.number("radius_m", 0.005, 2.0, "m")
    tables = list(document.tables("rotors"))
    if not 1 <= len(tables) <= MAX_ROTORS:
        document.fail("rotors", f"has {len(tables)} tables; valid: 4 to {MAX_ROTORS}")
    rotors = tuple(_rotor(own, shared) for own in tables)
    for (i, a), (j, b) in itertools.combinations(enumerate(rotors, start=1), 2):
        apart_m = math.dist(a.position_flu_m[:2], b.position_flu_m[:2])
        height_m = abs(a.position_flu_m[2] - b.position_flu_m[2])
        if apart_m < _LEAST_GAP * 2.0 * radius_m and height_m < _LEAST_STACKING * radius_m:
            document.fail(
                f"rotors[{j}].position_m",
                f"is {apart_m:.3g} m beside rotors[{i}]; valid: at least "
                f"{_LEAST_GAP * 2.0 * radius_m:.3g} m, or {_LEAST_STACKING * radius_m:.2g} m above",
            )
    found = RotorSet(
        rotors=rotors,
        radius_m=radius_m,
        inertia_kgm2=_optional(shared, "inertia_kgm2", 1e-10, 1.0, "kg m^2"),
        imbalance_kgm=_optional(shared, "imbalance_kgm", 0.0, 1e-2, "kg m"),
        friction_nm=_optional(shared, "friction_nm", 0.0, 1.0, "N m"),
    )
    shared.check_all_known()
    return found


def _optional(table: Fields, field: str, low: float, high: float, unit: str) -> float | None:
    return table.number(field, low, high, unit) if table.has(field) else None


def _rotor(own: Fields, shared: Fields) -> RotorParams:
    position = own.vector("position_m", 3, -_FARTHEST_M, _FARTHEST_M, "m")
    if math.hypot(*position[:2]) == 0.0:
        own.fail("position_m", f"is {list(position)}; valid: away from the centre of mass")
    spin = own.word("spin", tuple(_SPINS))
    axis = own.vector("axis", 3, -1.0, 1.0, default=(0.0, 0.0, 1.0))
    length = math.hypot(*axis)
    # A half is the cosine of 60 degrees.
    if length == 0.0 or axis[2] < 0.5 * length:
        own.fail("axis", f"is {list(axis)}; valid: [x, y, z] within 60 degrees of up")
    # A rotor's own table may override any of the common values.
    both = own.merged_under(shared)
    thrust_constant, torque_per_thrust_m = _curve(both)
    params = RotorParams(
        position_flu_m=_three(position),
        spin=_SPINS[spin],
        axis_flu=_three(tuple(each / length for each in axis)),
        thrust_constant=thrust_constant,
        torque_per_thrust_m=torque_per_thrust_m,
        time_constant_up_s=both.number("time_constant_up_s", 1e-3, 0.5, "s"),
        time_constant_down_s=both.number("time_constant_down_s", 1e-3, 0.5, "s"),
        max_speed_radps=both.number("max_speed_radps", 20.0, 2e4, "rad/s"),
        drag_coefficient=both.number("drag_coefficient", 0.0, 0.1, default=0.0),
        rolling_moment_coefficient=both.number("rolling_moment_coefficient", 0.0, 0.1, default=0.0),
    )
    # Fields that were read by way of both tables count as known in each.
    for table in (own, shared):
        table.know_as(both)
    own.check_all_known()
    return params


def _curve(table: Fields) -> tuple[float, float]:
    """Return thrust constant and torque over thrust, given or fitted to a measured curve."""
    if not table.has("curve_rpm_n_nm"):
        return (
            table.number("thrust_constant", 1e-11, 1e-1, "N s^2/rad^2"),
            table.number("torque_per_thrust_m", 1e-4, 1.0, "m"),
        )
    for field in ("thrust_constant", "torque_per_thrust_m"):
        if table.has(field):
            table.fail("curve_rpm_n_nm", f"stands beside {field}; valid: one of the two")
    rows = np.array(table.rows("curve_rpm_n_nm", 3, (3, 1000), 1e-9, 1e6))
    squares = (rows[:, 0] / _RPM_PER_RADPS) ** 2
    # Least squares of T = kf w^2 and M = km w^2 through the origin.
    constants = squares @ rows[:, 1:] / (squares @ squares)
    misfit = np.abs(np.outer(squares, constants) - rows[:, 1:]) / rows[:, 1:].max(axis=0)
    if misfit.max() > _MOST_MISFIT:
        row, column = np.unravel_index(misfit.argmax(), misfit.shape)
        table.fail(
            "curve_rpm_n_nm",
            f"has the row {rows[row].tolist()}, whose {('thrust', 'torque')[column]} is "
            f"{misfit.max():.0%} of the greatest away from one that grows with the square of the "
            f"speed; valid: up to {_MOST_MISFIT:.0%}",
        )
    return float(constants[0]), float(constants[1] / constants[0])


def _three(values: tuple[float, ...]) -> Vector3:
    x, y, z = values
    return (x, y, z)
