"""Agenda of a vehicle that explores, kept from one plan to the next.

Each plan is made anew from the present map. Without a memory the vehicle would turn away from
what it was about to look at, or look at the same hidden cells for ever. The agenda is that memory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from autonomy.planning.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True, eq=False)
class Errand:
    """Unseen cells on the path to a goal, and the place from which to look at them."""

    path: Int[np.ndarray, "n 3"]
    """Free cells to the place to look from; only that place's cell once the vehicle is there."""
    targets: Int[np.ndarray, "k 3"]
    """Cells to see."""
    facing_since: int | None = None
    """Value of `SeenMap.n_looks` when the camera began to face the cells; None before that."""
    needs_nod: bool = False
    """True if a level camera does not see the cells from there, so that the vehicle must tilt."""
    nods: int = 0
    """Number of nods so far."""


@dataclass(kw_only=True, eq=False)
class Agenda:
    """Memory of one flight; `plan_towards` changes it with every plan."""

    errand: Errand | None = None
    """Errand that the vehicle pursues; None without any."""
    searched_at: int = 0
    """Value of `SeenMap.n_looks` at the last search for a path."""
    plan: Trajectory | None = None
    """Last plan that was made; None before the first."""
