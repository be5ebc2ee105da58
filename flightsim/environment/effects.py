"""Physical effects that a run can switch off: each has a name and is on by default.

Switching one off shows how much of a result it explains, or gives another simulator's physics.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self


class EffectError(ValueError):
    """There is no effect of this name."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Effects:
    """Effects that are on; docs/physics.md has the model and the source of each."""

    frame_drag: bool = True
    """Arms, legs and motors have drag; without, the fuselage alone."""
    inflow: bool = True
    """Thrust follows the velocity through the rotor in climb, descent and vortex ring state, and
    blades that stand still have drag; without, thrust fades with axial speed (PX4's model)."""
    windmilling: bool = True
    """Motors without power coast and are turned by the air; without, they brake within 0.1 s."""
    ground: bool = True
    """More thrust near the ground."""
    ceiling: bool = True
    """More thrust below a ceiling, which draws the vehicle up."""
    vibration: bool = True
    """Rotors shake the IMU."""
    steel: bool = True
    """Cars, containers and other steel disturb the magnetometer."""
    motor_field: bool = True
    """The current of the motors disturbs the magnetometer."""
    sky: bool = True
    """Solids hide satellites: fixes are diluted, float or fail."""
    shelter: bool = True
    """Wind is less in the lee of buildings and more at their corners."""
    multipath: bool = True
    """Walls near the receiver reflect satellites' signals."""

    @classmethod
    def without(cls, text: str) -> Self:
        """Return all effects but those named in a list such as "ground,ceiling".

        Args:
            text: Names, separated by commas; empty keeps all effects.

        Raises:
            EffectError: If one is unknown, with the valid names.
        """
        names = [name.strip() for name in text.split(",") if name.strip()]
        valid = [field.name for field in fields(cls)]
        for name in names:
            if name not in valid:
                raise EffectError(f"without {name!r} is unknown; valid: {', '.join(valid)}")
        return cls(**dict.fromkeys(names, False))


ALL_EFFECTS = Effects()
NO_EFFECTS = Effects.without(",".join(field.name for field in fields(Effects)))
