"""Earth's magnetic field at the testbench.

The field is uniform over a scene. Simulator and estimator share this value, as an autopilot shares
the World Magnetic Model with its place.
"""

from __future__ import annotations

from autonomy.types import Vector3

FIELD_ENU_UT: Vector3 = (0.815, 21.493, -42.795)
"""North 21.493, east 0.815, down 42.795 uT: PX4's default place, Zurich (RotorS)."""
