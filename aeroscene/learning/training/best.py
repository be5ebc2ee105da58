"""The averaged weights with the least loss on held-out scenes, which are what generates.

A network that learns for long comes to know its scenes by heart: the held-out loss falls, then
rises. What is kept is from where it was least.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from torch import Tensor


@dataclass
class Best:
    """Where the held-out loss was least so far."""

    keeps_weights: bool = True
    """Whether the weights of that step are kept, beside its number."""
    loss: float = math.inf
    step: int = 0
    weights: dict[str, Tensor] = field(default_factory=dict)

    def offer(self, step: int, loss: float, weights: Mapping[str, Tensor]) -> bool:
        """Take what is better than all before; whether it is."""
        if not loss < self.loss:
            return False
        self.loss, self.step = loss, step
        if self.keeps_weights:
            self.weights = {name: value.detach().clone() for name, value in weights.items()}
        return True
