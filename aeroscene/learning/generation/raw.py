"""Skeletons to raw scenes: guided diffusion of their geometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import torch
from torch import Tensor

from aeroscene.learning.diffusion.loss import Denoiser
from aeroscene.learning.diffusion.sampling import Fixed, Moment, SamplerCfg, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.guidance.config import NO_GUIDANCE, GuidanceCfg, guidance_of
from aeroscene.learning.tokens.batch import Collator, TokenBatch, slots_of
from aeroscene.learning.tokens.boxes import Boxes
from aeroscene.learning.tokens.channels import Geometry
from aeroscene.learning.tokens.codec import DEFAULT_CODEC
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from aeroscene.learning.tokens.statistics import Statistics

OnStep = Callable[[Moment, Sequence[Geometry]], None]
"""Called with the layouts that are predicted at every step."""


class GeometrySampler:
    """A trained denoiser with all that turns its channels into boxes."""

    def __init__(
        self,
        model: Denoiser,
        vocabulary: Vocabulary,
        statistics: Statistics,
        schedule: Schedule,
        sampler: SamplerCfg,
        guidance: GuidanceCfg,
        device: torch.device,
    ) -> None:
        self._model = model
        self._vocabulary = vocabulary
        self._statistics = statistics
        self._decoder = TreeDecoder(vocabulary, statistics, device)
        self._schedule = schedule
        self._sampler = sampler
        # Guidance reads the default's channels.
        is_known = statistics.codec == DEFAULT_CODEC
        guidance = guidance if is_known else NO_GUIDANCE
        self._guidance = guidance_of(guidance, self._decoder, vocabulary, device)
        self._device = device

    def sample(
        self,
        skeletons: Sequence[Skeleton],
        wishes: Sequence[Wish],
        generator: torch.Generator,
        given: Sequence[np.ndarray] | None = None,
        on_step: OnStep | None = None,
    ) -> list[Geometry]:
        """Geometry for skeletons, from the noise of a generator on the device.

        `given` are for each scene the channels, [k, channels], of its first k tokens, which are not
        sampled: the site, or the whole coarse part.
        """
        # A new one each time: a collator keeps the heights of all skeletons that it has seen.
        collator = Collator(self._vocabulary, self._statistics)
        batch = collator.skeletons(skeletons, wishes).to(self._device)
        watch = None if on_step is None else self._watch(on_step, skeletons, batch)
        x0 = sample(
            self._model,
            batch,
            self._schedule,
            self._sampler,
            generator,
            guidance=self._guidance,
            fixed=self._fixed(given, skeletons, batch),
            x0_range=self._decoder.bounds(batch),
            on_step=watch,
        )
        return self._geometries(self._decoder.decode(x0, batch), skeletons, batch)

    def _watch(
        self, on_step: OnStep, skeletons: Sequence[Skeleton], batch: TokenBatch
    ) -> Callable[[Moment, Tensor, Tensor], None]:
        def watch(moment: Moment, x_t: Tensor, _: Tensor) -> None:
            boxes = self._decoder.decode(x_t, batch)
            on_step(moment, self._geometries(boxes, skeletons, batch))

        return watch

    def _fixed(
        self, given: Sequence[np.ndarray] | None, skeletons: Sequence[Skeleton], batch: TokenBatch
    ) -> Fixed | None:
        if given is None or not any(len(channels) for channels in given):
            return None
        assert batch.weight is not None
        mask = np.zeros(batch.mask.shape, dtype=bool)
        x0 = np.zeros(batch.weight.shape, dtype=np.float32)
        for row, (channels, skeleton) in enumerate(zip(given, skeletons, strict=True)):
            slots = slots_of(skeleton, batch)[: len(channels)]
            mask[row, slots] = True
            x0[row, slots] = channels
        return Fixed(*(torch.from_numpy(array).to(self._device) for array in (mask, x0)))

    def _geometries(
        self, boxes: Boxes, skeletons: Sequence[Skeleton], batch: TokenBatch
    ) -> list[Geometry]:
        center, heading, size, openings = (
            tensor.double().cpu().numpy()
            for tensor in (boxes.center_enu_m, boxes.heading, boxes.size_m, boxes.openings_m)
        )
        found: list[Geometry] = []
        for row, skeleton in enumerate(skeletons):
            slots = slots_of(skeleton, batch)
            cos, sin = heading[row, slots].T
            yaw = np.arctan2(sin, cos)
            found.append(Geometry(center[row, slots], yaw, size[row, slots], openings[row, slots]))
        return found
