"""Ground effect: thrust near a surface over thrust in open air, at the same rotor speed.

    symbol   name                                           unit
    R        radius of a rotor                              m
    z        height of the rotor above the surface          m
    d, b     distance of neighbouring and of opposite axes  m

    T / T_open = 1 / (1 - s),    s = (R/4z)^2 + R^2 z / (d^2 + 4z^2)^(3/2)
                 + (R^2/2) z / (2d^2 + 4z^2)^(3/2) + 2 R^2 K_b z / (b^2 + 4z^2)^(3/2)

The terms are the rotor's own image (Cheeseman and Bennett), those of its neighbours, that of the
opposite rotor, and the fountain under the body, K_b = 2. The wake trails behind a rotor with speed
across its axis, v_e, and s falls by 1 / (1 + (v_e / v_h)^2), v_h the induced velocity in hover.

Sources: Sanchez-Cuevas, Heredia and Ollero 2017, "Characterization of the aerodynamic ground effect
and its influence in multirotor control", for the whole quadrotor; Cheeseman and Bennett 1955, ARC
R&M 3021, for the speed. Nearer than R / 2 the images would be inside the rotor: s grows no more.
"""

from __future__ import annotations

from autonomy.jit import kernel

GROUND_REACH = 10.0
"""Height in rotor radii beyond which the effect, below 1%, is left out."""
_BODY_LIFT = 2.0  # K_b above
_LEAST_HEIGHT = 0.5  # least z over R


@kernel
def ground_share(height_m: float, radius_m: float, neighbour_m: float, opposite_m: float) -> float:
    """Return the sum s above, for a rotor at a height above a surface that lies across its axis.

    Args:
        height_m: Height of the rotor above the surface.
        radius_m: Radius of a rotor.
        neighbour_m: Distance of neighbouring axes.
        opposite_m: Distance of opposite axes.
    """
    z = max(height_m, _LEAST_HEIGHT * radius_m)
    square = radius_m * radius_m
    own = square / (16.0 * z * z)
    neighbours = square * z / (neighbour_m * neighbour_m + 4.0 * z * z) ** 1.5
    across = 0.5 * square * z / (2.0 * neighbour_m * neighbour_m + 4.0 * z * z) ** 1.5
    body = 2.0 * square * _BODY_LIFT * z / (opposite_m * opposite_m + 4.0 * z * z) ** 1.5
    return own + neighbours + across + body
