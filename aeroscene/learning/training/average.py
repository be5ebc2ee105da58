"""The moving average of a model's weights, with which scenes are generated.

The paper samples from the last weights. The average of many steps denoises better than the weights
of any single step, because it removes the noise of the last batches. `decay` 0 gives the paper's
reading.

Source: Ho, Jain and Abbeel 2020, appendix B (decay 0.9999 for long trainings).
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.optim.swa_utils import get_ema_multi_avg_fn


class MovingAverage:
    """Weights that follow a model's, smoothed.

    The model must stay on its device, because its tensors are kept.

    Args:
        model: The model to follow.
        decay: Share of the old average that stays in each step, 0 to below 1.
    """

    def __init__(self, model: nn.Module, decay: float) -> None:
        self._decay = decay
        followed = {name: value.detach() for name, value in model.state_dict().items()}
        self.weights: dict[str, Tensor] = {name: v.clone() for name, v in followed.items()}
        # Counters and other integers cannot be averaged; they are copied.
        smooth = [name for name, value in followed.items() if value.is_floating_point()]
        self._from, self._to = [[of[name] for name in smooth] for of in (followed, self.weights)]
        self._counts = [(self.weights[name], followed[name]) for name in followed.keys() - smooth]

    @torch.no_grad()
    def update(self, step: int) -> None:
        """Follow the model after a step.

        The decay grows towards its value, so that the first steps are forgotten soon.

        Args:
            step: Number of the step, from 1.
        """
        # From 2/11 at the first step to the full decay after many.
        decay = min(self._decay, (1 + step) / (10 + step))
        get_ema_multi_avg_fn(decay)(self._to, self._from, step)
        for mine, theirs in self._counts:
            mine.copy_(theirs)

    @torch.no_grad()
    def load(self, weights: Mapping[str, Tensor]) -> None:
        """Continue from a saved average."""
        for name, value in self.weights.items():
            value.copy_(weights[name])
