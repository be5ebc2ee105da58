"""Agenda of a vehicle that explores, kept from one plan to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from autonomy.planning.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True, eq=False)
class Errand:
    """Cells on the way to a goal that must be seen first, and the place to see them from."""

    path: Int[np.ndarray, "n 3"]
    """Free cells to the place to look from; the last alone if that is where the vehicle is."""
    targets: Int[np.ndarray, "k 3"]
    facing_since: int | None = None
    """Number of images taken before the camera faced the cells."""
    needs_nod: bool = False
    """Whether the cells are seen from there only when the vehicle tilts."""
    nods: int = 0
    """Number of nods so far."""


@dataclass(kw_only=True, eq=False)
class Agenda:
    """The present errand and the last attempts."""

    errand: Errand | None = None
    """Cells that the vehicle set out to look at, None without any."""
    searched_at: int = 0
    """Number of images taken before the last search for a way."""
    plan: Trajectory | None = None
    """Last plan that was made."""
