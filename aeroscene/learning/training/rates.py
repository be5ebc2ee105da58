"""The learning rate over a training.

    symbol  meaning                      range
    f       share of the training done   0 to 1
    r       factor on the learning rate  0 to 1

A rate that follows the share instead of a number of steps also works if the length is given in
minutes.
"""

from __future__ import annotations

import math
from typing import Literal

RateSchedule = Literal["cosine", "cooldown", "constant"]


def rate_factor(
    schedule: RateSchedule, f: float, step: int, *, warmup_steps: int, cooldown_share: float
) -> float:
    """Factor on the learning rate before a step.

    Args:
        schedule: `cosine` is the paper's, r = (1 + cos(pi f)) / 2. `cooldown` holds the rate and
            lets it fall in a straight line at the end, so that a longer training can go on from
            where it was held. `constant` holds it.
        f: Share of the training done.
        step: Steps done.
        warmup_steps: Steps over which the rate grows from nothing.
        cooldown_share: Share of the training at its end in which the rate falls.

    Source: Loshchilov and Hutter 2017 (cosine); Hägele et al. 2024 (cooldown).
    """
    # Warm-up counts in steps, the fall in shares of the training.
    warm = min(1.0, (step + 1) / max(1, warmup_steps))
    f = min(1.0, f)
    if schedule == "cosine":
        return warm * 0.5 * (1.0 + math.cos(math.pi * f))
    if schedule == "cooldown":
        # Never divided by zero: with a share of 0 the rate stays full until the end.
        return warm * min(1.0, (1.0 - f) / max(cooldown_share, 1e-9))
    return warm
