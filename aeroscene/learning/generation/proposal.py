"""What a trained model proposes before feasibility: one way for each preset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
import torch

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.generation.request import Request, Themes
from aeroscene.learning.wishes import Wish
from aeroscene.scene import Scene


class Proposal(Protocol):
    """Scene as the model proposes it."""

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """The raw scene, without interaction areas; `rng` draws the looks.

        Raises:
            SceneError: If a number is not finite.
        """
        ...


OnStep = Callable[[Moment, Sequence[Proposal]], None]
"""Called at every step of the denoising with the noisy layouts as they are."""


class Proposer(Protocol):
    """A trained model that makes scenes."""

    @property
    def themes(self) -> Themes:
        """Themes that may be asked for."""
        ...

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> Sequence[Proposal]:
        """One scene for each request; `rngs` draw what each needs."""
        ...


def noise_of(rngs: Sequence[np.random.Generator], device: torch.device) -> torch.Generator:
    """The noise of scenes that are denoised together: the first one's generator seeds it."""
    return torch.Generator(device).manual_seed(int(rngs[0].integers(2**63)))
