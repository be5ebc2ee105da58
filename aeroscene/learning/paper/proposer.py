"""The paper's way: all objects at once, absolute, without a skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from aeroscene.learning.diffusion.loss import Denoiser
from aeroscene.learning.diffusion.sampling import Guidance, Moment, SamplerCfg, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.proposal import OnStep, noise_of
from aeroscene.learning.generation.request import NO_THEMES, Request, RequestError, Themes
from aeroscene.learning.paper.tokens import FlatStatistics, empty_flat_batch, read_flat
from aeroscene.learning.tokens.assembly import assemble
from aeroscene.learning.tokens.geometry import Geometry
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from aeroscene.scene import Scene


@dataclass(frozen=True)
class FlatProposal:
    """Objects beside each other, of kinds that were drawn within their categories."""

    skeleton: Skeleton
    geometry: Geometry
    vocabulary: Vocabulary

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """The scene as sampled, without areas; `rng` draws the looks.

        Raises:
            SceneError: If a number is not finite.
        """
        return assemble(
            self.skeleton, self.geometry, self.vocabulary, scene_id=scene_id, seed=seed, rng=rng
        )


class FlatProposer:
    """The paper's algorithm 2, to the letter."""

    def __init__(
        self,
        model: Denoiser,
        vocabulary: Vocabulary,
        statistics: FlatStatistics,
        schedule: Schedule,
        sampler: SamplerCfg,
        guidance: Guidance,
        device: torch.device,
    ) -> None:
        self._vocabulary = vocabulary
        self._model = model
        self._statistics = statistics
        self._schedule = schedule
        self._sampler = sampler
        self._guidance = guidance
        self._device = device
        # DDPM's clipping of the prediction: one object of 300 kilometres spoils a whole scene.
        self._x0_range = (
            torch.as_tensor(statistics.low, dtype=torch.float32, device=device),
            torch.as_tensor(statistics.high, dtype=torch.float32, device=device),
        )

    @property
    def themes(self) -> Themes:
        """None: the paper's layouts say nothing of what the place is."""
        return NO_THEMES

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> list[FlatProposal]:
        """Layouts of as many objects as wished for.

        Raises:
            RequestError: If an outline or a scene is given: the paper has neither.
        """
        for request in requests:
            if request.given is not None or request.outline_m is not None:
                raise RequestError(
                    "an outline or a scene is given with the paper's preset, valid: neither; "
                    "--preset default takes them"
                )
        counts = [(wish.n_coarse, wish.n_fine) for wish in wishes]
        batch = empty_flat_batch(wishes, counts).to(self._device)

        def watch(moment: Moment, x_t: Tensor, x0: Tensor) -> None:
            del x0
            if on_step is not None:
                # Its own draws of kinds: looking on changes nothing.
                on_step(moment, self._read(x_t, batch.mask, wishes, _same(wishes)))

        x0 = sample(
            self._model,
            batch,
            self._schedule,
            self._sampler,
            noise_of(rngs, self._device),
            guidance=self._guidance,
            x0_range=self._x0_range,
            on_step=watch,
        )
        return self._read(x0, batch.mask, wishes, rngs)

    def _read(
        self, x: Tensor, mask: Tensor, wishes: Sequence[Wish], rngs: Sequence[np.random.Generator]
    ) -> list[FlatProposal]:
        layouts, is_there = x.double().cpu().numpy(), mask.cpu().numpy()
        return [
            FlatProposal(
                *read_flat(layout[real], wish, self._statistics, self._vocabulary, rng),
                self._vocabulary,
            )
            for layout, real, wish, rng in zip(layouts, is_there, wishes, rngs, strict=True)
        ]


def _same(wishes: Sequence[Wish]) -> list[np.random.Generator]:
    return [np.random.default_rng(0) for _ in wishes]
