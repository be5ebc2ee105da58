"""From wishes to raw scenes' skeletons and geometry: one way for each preset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch
from jaxtyping import Float

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.generation.raw import GeometrySampler
from aeroscene.learning.generation.request import Request, RequestError
from aeroscene.learning.skeleton.model import SkeletonModel
from aeroscene.learning.skeleton.sample import sample_skeletons
from aeroscene.learning.tokens.channels import HEADING, SIZE, Geometry
from aeroscene.learning.tokens.examples import Example, encode
from aeroscene.learning.tokens.kinds import DOMAINS, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from aeroscene.learning.tokens.statistics import Statistics


@dataclass(frozen=True)
class Proposal:
    """Scene as the model proposes it, before feasibility."""

    skeleton: Skeleton
    geometry: Geometry


OnStep = Callable[[Moment, Sequence[Proposal]], None]
"""Called at every step of the denoising with the noisy layouts as they are."""


class Proposer(Protocol):
    """A trained model that makes scenes."""

    vocabulary: Vocabulary

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> list[Proposal]:
        """One scene for each request; `rngs` draw what each needs."""
        ...


def noise_of(rngs: Sequence[np.random.Generator], device: torch.device) -> torch.Generator:
    """The noise of scenes that are denoised together: the first one's generator seeds it."""
    return torch.Generator(device).manual_seed(int(rngs[0].integers(2**63)))


class HierarchicalProposer:
    """Ours: the skeleton first, then its geometry."""

    def __init__(
        self,
        vocabulary: Vocabulary,
        statistics: Statistics,
        skeletons: SkeletonModel,
        sampler: GeometrySampler,
        device: torch.device,
    ) -> None:
        self.vocabulary = vocabulary
        self._statistics = statistics
        self._skeletons = skeletons
        self._sampler = sampler
        self._device = device

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> list[Proposal]:
        """Skeletons by wish, then guided diffusion of all their geometry at once.

        Raises:
            RequestError: If a scene to complete has objects of categories that the model never saw.
        """
        given = [self._given(request) for request in requests]
        kept = [None if part is None else part.skeleton for part in given]
        skeletons = sample_skeletons(self._skeletons, wishes, rngs, kept)
        known = [
            self._known_channels(request, part, skeleton)
            for request, part, skeleton in zip(requests, given, skeletons, strict=True)
        ]

        def proposed(layouts: Sequence[Geometry]) -> list[Proposal]:
            return [Proposal(*pair) for pair in zip(skeletons, layouts, strict=True)]

        watch = None if on_step is None else lambda at, layouts: on_step(at, proposed(layouts))
        noise = noise_of(rngs, self._device)
        return proposed(self._sampler.sample(skeletons, wishes, noise, known, watch))

    def _given(self, request: Request) -> Example | None:
        """The coarse part of the scene that is to be completed."""
        part = request.kept
        if part is None:
            return None
        try:
            return encode(part, self.vocabulary, self._statistics, allow_nearest=True)
        except KeyError as error:
            known = sorted({kind.category for kind in self.vocabulary.kinds if not kind.is_site})
            raise RequestError(
                f"scene {part.scene_id!r} has an object of category {error.args[0]!r}, which the "
                f"model never saw, valid: {', '.join(known)}"
            ) from None

    def _known_channels(
        self, request: Request, given: Example | None, skeleton: Skeleton
    ) -> Float[np.ndarray, "k channels"]:
        """Channels of the first tokens: a given coarse part, a given outline, or nothing."""
        if given is not None:
            return given.x0
        kind = DOMAINS.index(skeleton.domain)
        mean, spread = self._statistics.mean[kind], self._statistics.spread[kind]
        channels = np.zeros((1, len(mean)))
        if request.outline_m is None:
            return channels[:0]
        channels[0, HEADING] = (1.0, 0.0)
        channels[0, SIZE.start : SIZE.start + 2] = self._statistics.codec.extents(
            np.log(request.outline_m)
        )
        return np.where(self._statistics.is_free[kind], (channels - mean) / spread, 0.0)
