"""The agenda of a vehicle that explores, from one plan to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from autonomy.planning.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True, eq=False)
class Errand:
    """Cells that the way to a goal leads through, and from where they can be seen."""

    path: Int[np.ndarray, "n 3"]
    """Free cells to the place to look from; the last alone if that is where the vehicle is."""
    targets: Int[np.ndarray, "k 3"]
    facing_since: int | None = None
    """Images that had been taken when the camera faced them."""
    needs_nod: bool = False
    """Whether they are seen from there only when the vehicle tilts."""
    nods: int = 0
    """Nods so far."""


@dataclass(kw_only=True, eq=False)
class Agenda:
    """The present errand and the last attempts."""

    errand: Errand | None = None
    """Cells that the vehicle set out to look at, None without any."""
    searched_at: int = 0
    """Images that had been taken when a way was last looked for."""
    plan: Trajectory | None = None
    """The last one that was made."""
