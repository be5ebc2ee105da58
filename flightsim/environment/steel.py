"""Steel of a scene, as dipoles that the Earth's field induces.

    symbol   name                                               unit
    B        the Earth's field                                  uT
    r        radius of the ball of the object's bounding volume m
    d, n     distance and direction from its centre             m
    t, mu    thickness and relative permeability of the sheet   m

    disturbance = chi (r / d)^3 (3 n (n . B) - B),    chi = s / (1 + s),    s = 2 mu t / 3 r

It is the field outside of a thin permeable shell in a uniform field. A car of 1.3 m has 1 uT at
3 m, and 2 to 3 uT at 2 m, as magnetometers beside roads see it. Nearer than r it grows no more.

Source: Jackson 1999, Classical Electrodynamics, section 5.12, for a thin shell.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.scene.catalogue import CATALOGUE
from autonomy.jit import kernel

STEEL_COLUMNS = ("x", "y", "z", "radius", "chi")
_SHEET_M = 1e-3  # thickness of the sheet
_PERMEABILITY = 200.0
_LEAST_RADIUS_M = 0.25  # smaller objects are left out
_REACH = 6.0
"""Distance in radii beyond which the disturbance, below 0.5% of chi, is left out."""


def steel_dipoles(scene: Scene) -> Float[np.ndarray, "n 5"]:
    """Return objects of steel, by their category's surface, a row of `STEEL_COLUMNS` each."""
    rows = []
    for thing in scene.objects:
        # The ball with the volume of the bounding box.
        radius_m = (math.prod(thing.bbox.s) * 0.75 / math.pi) ** (1.0 / 3.0)
        if CATALOGUE[thing.category_id].surface == "metal" and radius_m >= _LEAST_RADIUS_M:
            share = 2.0 * _PERMEABILITY * _SHEET_M / (3.0 * radius_m)
            rows.append((*thing.bbox.p, radius_m, share / (1.0 + share)))
    return np.array(rows, dtype=float).reshape(-1, len(STEEL_COLUMNS))


@kernel
def disturb(
    dipoles: np.ndarray, position_enu_m: np.ndarray, earth_ut: np.ndarray, total_ut: np.ndarray
) -> None:
    """Add the disturbance of the dipoles to a field.

    Args:
        dipoles: Rows of `STEEL_COLUMNS` (n, 5).
        position_enu_m: Position of the magnetometer (3,).
        earth_ut: The Earth's field (3,), which magnetises them.
        total_ut: Field (3,), changed.
    """
    for k in range(dipoles.shape[0]):
        dipole = dipoles[k]
        x = position_enu_m[0] - dipole[0]
        y = position_enu_m[1] - dipole[1]
        z = position_enu_m[2] - dipole[2]
        square = x * x + y * y + z * z
        radius = dipole[3]
        if square > _REACH * _REACH * radius * radius or square == 0.0:
            continue
        # Within the ball the field would grow without bound: it stays at that of the surface.
        share = radius / max(math.sqrt(square), radius)
        strength = dipole[4] * share * share * share
        along = 3.0 * (x * earth_ut[0] + y * earth_ut[1] + z * earth_ut[2]) / square
        total_ut[0] += strength * (along * x - earth_ut[0])
        total_ut[1] += strength * (along * y - earth_ut[1])
        total_ut[2] += strength * (along * z - earth_ut[2])
