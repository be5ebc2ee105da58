"""The averaged weights with the least loss on held-out scenes, with which scenes are generated.

A network that trains for long memorises its scenes: the held-out loss falls, then rises. Therefore
the weights of its minimum are kept.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from torch import Tensor


@dataclass
class Best:
    """Step and weights at which the held-out loss was least so far."""

    keeps_weights: bool = True
    """True keeps the weights of that step beside its number."""
    loss: float = math.inf
    step: int = 0
    weights: dict[str, Tensor] = field(default_factory=dict)

    def offer(self, step: int, loss: float, weights: Mapping[str, Tensor]) -> bool:
        """Keep the weights if the loss is less than all before.

        Args:
            step: Number of the step.
            loss: Held-out loss of the weights.
            weights: Averaged weights; they are copied.

        Returns:
            True if they are kept.
        """
        # Written so that a loss that is not a number is refused, too.
        if not loss < self.loss:
            return False
        self.loss, self.step = loss, step
        if self.keeps_weights:
            self.weights = {name: value.detach().clone() for name, value in weights.items()}
        return True
