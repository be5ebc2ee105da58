"""The moving average of a model's weights, which is what generates.

Not in the paper, which samples from the last weights: the average of many steps denoises better
than any of them. `decay` 0 is the paper's reading.

Source: Ho, Jain and Abbeel 2020, appendix B (decay 0.9999 for long trainings).
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.optim.swa_utils import get_ema_multi_avg_fn


class MovingAverage:
    """Weights that follow a model's, smoothed.

    The model must stay on its device: its tensors are kept.
    """

    def __init__(self, model: nn.Module, decay: float) -> None:
        self._decay = decay
        followed = {name: value.detach() for name, value in model.state_dict().items()}
        self.weights: dict[str, Tensor] = {name: v.clone() for name, v in followed.items()}
        smooth = [name for name, value in followed.items() if value.is_floating_point()]
        self._from, self._to = [[of[name] for name in smooth] for of in (followed, self.weights)]
        self._counts = [(self.weights[name], followed[name]) for name in followed.keys() - smooth]

    @torch.no_grad()
    def update(self, step: int) -> None:
        """Follow the model after its step number `step`, counted from 1.

        The decay grows towards its value, so that the first steps are forgotten soon.
        """
        decay = min(self._decay, (1 + step) / (10 + step))
        get_ema_multi_avg_fn(decay)(self._to, self._from, step)
        for mine, theirs in self._counts:
            mine.copy_(theirs)

    @torch.no_grad()
    def load(self, weights: Mapping[str, Tensor]) -> None:
        """Go on from an average that was saved."""
        for name, value in self.weights.items():
            value.copy_(weights[name])
