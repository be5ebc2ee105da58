"""Velocity of the air through a rotor: climb, forward flight, descent, vortex ring, and a ceiling.

    symbol   name                                                  unit
    v_h      induced velocity in hover at the same rotor speed     m/s
    v_c      velocity along the axis, climb positive               m/s
    v_e      velocity across the axis                              m/s
    x, y     v_c / v_h, v_e / v_h
    f        induced velocity over v_h

    momentum theory           f sqrt(y^2 + (x + f)^2) = 1
    vortex ring, -2 < x < 0   f = 1 - 1.125 x - 1.372 x^2 - 1.718 x^3 - 0.655 x^4
    windmill, x < -2          f = -x/2 - sqrt(x^2/4 - 1)

Momentum theory holds in climb and in forward flight, where f falls. In descent along the axis the
wake returns into the rotor; the second law is a fit to measurements there. Speed across the axis
blows the ring away: what the last two laws add to the first counts by 1 / (1 + y^2)^2.

Below a ceiling at a gap z the air enters through the side of the gap, at v_i R / 2 z on the rim.
Bernoulli's law gives a suction of rho v_i^2 / 16 (R / z)^2 over the disc, hence T = 2 rho A v_i^2
(1 + (R / z)^2 / 32), and f is that much less.

Sources: Leishman 2006, Principles of Helicopter Aerodynamics, chapter 2, momentum analysis in axial
climb and descent and in forward flight, with the fit; the ceiling by the same theory, in the manner
of Hsiao and Chirarattananon 2019, "Ceiling effects for hybrid aerial-surface locomotion of small
rotorcraft". That speed across ends the vortex ring is known, how fast is our choice.
"""

from __future__ import annotations

import math

from autonomy.jit import kernel

CEILING_REACH = 4.0
"""Gap in rotor radii beyond which the effect of a ceiling, below 0.1%, is left out."""
_NEWTON_STEPS = 4


@kernel
def induced_ratio(x: float, square_y: float) -> float:
    """Return the induced velocity over that in hover.

    Args:
        x: Velocity along the axis over the induced velocity in hover, climb positive.
        square_y: Velocity across the axis over the same, squared.
    """
    f = _momentum_ratio(x, square_y)
    # In climb momentum theory holds alone.
    if x >= 0.0:
        return f
    straight = 1.0 / (1.0 + square_y)
    return f + straight * straight * (_descent_ratio(x) - _climb_ratio(x))


@kernel
def _momentum_ratio(x: float, square_y: float) -> float:
    """Solve momentum theory by Newton's method from above, where it converges without fail."""
    f = _climb_ratio(x)
    if square_y < 1e-6:
        return f
    # Both are upper bounds: f falls with speed across, and f y <= 1.
    f = min(f, 1.0 / math.sqrt(square_y))
    for _ in range(_NEWTON_STEPS):
        through = x + f
        square = square_y + through * through
        f -= (f * f * square - 1.0) / (2.0 * f * (square + f * through))
    return f


@kernel
def _climb_ratio(x: float) -> float:
    """Induced velocity over that in hover by momentum theory along the axis."""
    return -0.5 * x + math.sqrt(0.25 * x * x + 1.0)


@kernel
def _descent_ratio(x: float) -> float:
    """Induced velocity over that in hover in the vortex ring and as a windmill brake."""
    if x > -2.0:
        return 1.0 + x * (-1.125 + x * (-1.372 + x * (-1.718 - 0.655 * x)))
    return -0.5 * x - math.sqrt(0.25 * x * x - 1.0)


@kernel
def ceiling_ratio(gap_m: float, radius_m: float) -> float:
    """Return the induced velocity over that without a ceiling.

    Args:
        gap_m: Distance from the rotor up to the ceiling.
        radius_m: Radius of the rotor.
    """
    share = radius_m / gap_m
    return 1.0 / math.sqrt(1.0 + share * share / 32.0)
