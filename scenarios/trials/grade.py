"""One number for a trial, so that stacks differ even if all of them succeed or all fail.

A rate of success separates two stacks only by trials that one lands and the other does not. The
grade adds how near a failed flight came and whether the vehicle survived it, and how fast a success
was. A success is always worth more than any failure:

    success   0.7 + 0.3 pace       pace: least possible time of the path over the time it took
    failure   0.3 progress + 0.2   progress: share of the distance that it came nearer, 1 above
                                   the area; the 0.2 only if it ended safely down
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from scenarios.trials.verdict import Fate

SUCCESS, PACE = 0.7, 0.3
PROGRESS, SAFE = 0.3, 0.2


def grade(row: Mapping[str, Any]) -> float | None:
    """Return the grade of a trial, 0 to 1; None if nothing was to be judged.

    Args:
        row: Its `success`, and as far as they exist `progress`, `fate`, `navigation_s` and
            `least_navigation_s`.
    """
    if row.get("success") is None:
        return None
    if row["success"]:
        took_s, least_s = row.get("navigation_s"), row.get("least_navigation_s")
        # Without both times a success has no pace.
        pace = min(1.0, least_s / took_s) if took_s and least_s else 0.0
        return round(SUCCESS + PACE * pace, 4)
    # Rows come from tables, where the fate is a word.
    is_safe = row.get("fate") == Fate.SAFE_DOWN.value
    return round(PROGRESS * (row.get("progress") or 0.0) + SAFE * is_safe, 4)


def progress(
    flown_enu_m: Float[np.ndarray, "n 3"], area_enu_m: Float[np.ndarray, " 3"], *, has_reached: bool
) -> float:
    """Return the share of the distance to the area that a flight's nearest point made up, 0 to 1.

    Args:
        flown_enu_m: True path, its first point the start; without points nothing was made up.
        area_enu_m: Centroid of the area.
        has_reached: True if it came above the area, which counts as the whole distance.
    """
    if has_reached:
        return 1.0
    if len(flown_enu_m) == 0:
        return 0.0
    away_m = np.linalg.norm(np.asarray(flown_enu_m, dtype=float) - area_enu_m, axis=1)
    return round(float(1.0 - away_m.min() / max(away_m[0], 1e-9)), 4)
