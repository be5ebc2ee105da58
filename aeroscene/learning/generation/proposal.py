"""The interface between a trained model and the projection, which every preset implements."""

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
    """A scene as the model proposes it."""

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """Build the raw scene, without interaction areas; `rng` draws the looks.

        Raises:
            SceneError: If a number is not finite.
        """
        ...


OnStep = Callable[[Moment, Sequence[Proposal]], None]
"""Callback at every step of the denoising, with the noisy layouts as they are."""


class Proposer(Protocol):
    """A trained model that makes scenes."""

    @property
    def themes(self) -> Themes:
        """Themes that a request may name, by domain."""
        ...

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> Sequence[Proposal]:
        """Propose one scene for each request.

        Args:
            requests: Scenes to make.
            wishes: Contents of each scene, with nothing left open.
            rngs: Source of the random numbers of each scene.
            on_step: Called at every step of the denoising.
        """
        ...


def noise_of(rngs: Sequence[np.random.Generator], device: torch.device) -> torch.Generator:
    """Return the noise of scenes that are denoised together, seeded by the first one's generator.

    A scene's noise therefore depends on its batch.
    """
    # A NumPy draw below 2**63 is a valid seed of a PyTorch generator.
    return torch.Generator(device).manual_seed(int(rngs[0].integers(2**63)))
