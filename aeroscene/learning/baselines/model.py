"""What every learned baseline is to the training and to whoever draws scenes from it."""

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
    """Denoising steps, where a method diffuses. DiffuScene takes 1,000; the AeroScene paper takes
    100 and says that it is comparable to its baselines."""

    def __post_init__(self) -> None:
        require_ranges(self, TrainingError)
        ok = self.width % (2 * self.heads) == 0
        require(ok=ok, name="width", value=self.width, valid=f"a multiple of {2 * self.heads}")


class BaselineModel(nn.Module, ABC):
    """A network that learns layouts and draws them."""

    def __init__(self, code: LayoutCode) -> None:
        super().__init__()
        self.code = code

    @abstractmethod
    def forward(self, batch: TokenBatch, generator: torch.Generator) -> LossTerms:
        """Loss of a batch; its term `total` is what is minimised."""

    @abstractmethod
    def draw(self, domain: int, generator: torch.Generator) -> FlatBoxes:
        """A layout of a domain, by its place among `DOMAINS`; the generator draws everything."""
