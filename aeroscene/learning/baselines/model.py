"""The interface of a learned baseline, for its training and for drawing scenes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated

import torch
from torch import nn

from aeroscene.learning.baselines.layouts import LayoutCode
from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.training.config import TrainingError, require
from aeroscene.learning.training.loop import LossTerms
from aeroscene.ranges import Range, require_ranges


@dataclass(frozen=True, kw_only=True)
class BaselineCfg:
    """Size and sampling of a baseline."""

    width: Annotated[int, Range(1, 4096)] = 192
    """Width of a token. DiffuScene and ATISS have 512; a fifth of our budget would go that far."""
    levels: Annotated[int, Range(1, 64)] = 4
    """Levels of a UNet on each side, or layers of a transformer."""
    heads: Annotated[int, Range(1, 64)] = 8
    steps: Annotated[int, Range(1, 1000)] = 100
    """Denoising steps of methods that diffuse. DiffuScene takes 1,000; the AeroScene paper takes
    100 and says that it is comparable to its baselines."""

    def __post_init__(self) -> None:
        require_ranges(self, TrainingError)
        # Each head needs an even width: sine and cosine features come in pairs.
        ok = self.width % (2 * self.heads) == 0
        require(ok=ok, name="width", value=self.width, valid=f"a multiple of {2 * self.heads}")


class BaselineModel(nn.Module, ABC):
    """A network that learns layouts and draws them."""

    def __init__(self, code: LayoutCode) -> None:
        super().__init__()
        self.code = code

    @abstractmethod
    def forward(self, batch: TokenBatch, generator: torch.Generator) -> LossTerms:
        """Return the loss of a batch; the training minimises its term `total`."""

    @abstractmethod
    def draw(self, domain: int, generator: torch.Generator) -> FlatBoxes:
        """Draw a layout of a domain.

        Args:
            domain: Place of the domain among `DOMAINS`.
            generator: Source of every random number of the draw.
        """
