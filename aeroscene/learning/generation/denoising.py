"""Diffusion of the channels of drawn programs; given channels stay as they are.

The writer has drawn the tokens before. This module draws all their numbers at once, for several
programs in one batch. A scene to complete, or an outline that the user gives, fixes some channels:
the sampler holds them, and the finished program gets the exact given values once more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import SamplerCfg
from aeroscene.learning.diffusion.loss import Denoiser
from aeroscene.learning.diffusion.sampling import Fixed, Moment, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.given import PlacedPart
from aeroscene.learning.generation.proposal import OnStep
from aeroscene.learning.program import DecodingCfg, Program, decode
from aeroscene.learning.program.batch import channels_in, program_batch, slots_of
from aeroscene.learning.program.kinds import Kind
from aeroscene.learning.program.program import COS, N_CHANNELS, SIN, SIZE, U, V
from aeroscene.learning.program.statistics import ProgramExample, from_example, on_atoms
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.language import Language
from aeroscene.scene import Scene

_SITE_FRAME: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
_UNIT_FRAME: tuple[int, ...] = (U, V, COS, SIN, SIZE.start, SIZE.start + 1)
"""Channels of middle, heading and log sides, of a site's record and of a unit."""


@dataclass(frozen=True, eq=False)
class Draft:
    """A program whose channels are not drawn yet."""

    example: ProgramExample
    wish: Wish
    given: PlacedPart | None = None
    """Tokens of it that are given."""
    outline_m: tuple[float, float] | None = None
    """Sides of its site, if they are given, m."""


@dataclass(frozen=True, eq=False)
class ProgramProposal:
    """A program with its channels."""

    example: ProgramExample
    language: Language
    draft: Draft
    decoding: DecodingCfg

    @property
    def program(self) -> Program:
        """Program in metres and radians, with given tokens exactly as given.

        Given values count even if they are out of the range of training.
        """
        known, draft = self.language, self.draft
        # Back to metres and radians before anything is put in.
        program = from_example(self.example, known.vocabulary, known.statistics)
        # Before given values are put in: those must stay as they are.
        program = on_atoms(program, known.statistics.atoms)
        if draft.given is not None:
            return draft.given.imposed_on(program)
        if draft.outline_m is not None:
            place, numbers = frame_of(self.example, known)
            channels = program.channels.copy()
            channels[place, numbers] = frame_values(draft.outline_m, program.kinds[place])
            return program.with_channels(channels)
        return program

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """Decode the scene, without areas; `rng` draws the looks."""
        program = self.language.vocabulary.with_looks(self.program, rng)
        given = self.draft.given
        if given is not None:
            return given.furnished(program, scene_id, seed)
        return decode(program, scene_id, seed, self.decoding).scene


class Denoising:
    """A trained denoiser, with everything that its channels are read by."""

    def __init__(
        self,
        language: Language,
        denoiser: Denoiser,
        schedule: Schedule,
        sampler: SamplerCfg,
        device: torch.device,
        decoding: DecodingCfg | None = None,
    ) -> None:
        self._decoding = decoding or DecodingCfg()
        self._language = language
        self._denoiser = denoiser
        self._schedule = schedule
        self._sampler = sampler
        self.device = device
        statistics = language.statistics
        self._range = tuple(
            torch.as_tensor(each, dtype=torch.float32, device=device)
            for each in (statistics.low, statistics.high)
        )

    def denoise(
        self, drafts: Sequence[Draft], noise: torch.Generator, on_step: OnStep | None = None
    ) -> list[ProgramProposal]:
        """Draw the channels of all programs at once.

        Args:
            drafts: Programs without channels.
            noise: Source of all noise, on the model's device.
            on_step: Called at every step with the noisy programs.

        Returns:
            The programs with channels, in the order of the drafts.
        """
        examples = [draft.example for draft in drafts]
        wishes = [draft.wish for draft in drafts]
        batch = program_batch(examples, wishes, self._language.statistics).to(self.device)

        def proposed(x: Tensor) -> list[ProgramProposal]:
            placed = (
                channels_in(x, each, row, batch.n_coarse_slots) for row, each in enumerate(examples)
            )
            pairs = zip(placed, drafts, strict=True)
            return [
                ProgramProposal(each, self._language, draft, self._decoding)
                for each, draft in pairs
            ]

        watch: Callable[[Moment, Tensor, Tensor], None] | None = None
        if on_step is not None:
            watch = lambda at, x_t, _: on_step(at, proposed(x_t))  # noqa: E731
        # Clipped to the range of training, kind by kind.
        low, high = (each[batch.kind] for each in self._range)
        x0 = sample(
            self._denoiser,
            batch,
            self._schedule,
            self._sampler,
            noise,
            fixed=self._fixed(drafts, batch),
            x0_range=(low, high),
            on_step=watch,
        )
        return proposed(x0)

    def _fixed(self, drafts: Sequence[Draft], batch: TokenBatch) -> Fixed | None:
        """Collect channels of given parts and of outlines; None if there are none."""
        mask = np.zeros((*batch.mask.shape, N_CHANNELS), dtype=bool)
        x0 = np.zeros(mask.shape, dtype=np.float32)
        for row, draft in enumerate(drafts):
            slots, given = slots_of(draft.example.skeleton, batch.n_coarse_slots), draft.given
            if given is not None:
                mask[row, slots[given.places]] = True
                x0[row, slots[given.places]] = given.part.example.x0[given.own]
            elif draft.outline_m is not None:
                place, channels = frame_of(draft.example, self._language)
                number, known = draft.example.skeleton.kind_id[place], self._language
                statistics = known.statistics
                kind = known.vocabulary.kinds[number]
                values = frame_values(draft.outline_m, kind) - statistics.mean[number, channels]
                # A channel that never varied in training has no spread and stays at its mean.
                mask[row, slots[place], channels] = statistics.is_free[number, channels]
                x0[row, slots[place], channels] = values / statistics.spread[number, channels]
        if not mask.any():
            return None
        return Fixed(*(torch.from_numpy(array).to(self.device) for array in (mask, x0)))


def frame_of(example: ProgramExample, language: Language) -> tuple[int, list[int]]:
    """Find the token that has the outline, and its six channels of the outline.

    The token is the site's; without a site it is the building's.
    """
    kinds = language.vocabulary.kinds
    nodes = [kinds[number].node for number in example.skeleton.kind_id.tolist()]
    if "site" in nodes:
        return nodes.index("site"), list(_SITE_FRAME)
    bearers = [int(example.skeleton.parent[i]) for i, node in enumerate(nodes) if node == "storey"]
    return next((i for i in bearers if nodes[i] == "unit"), 0), list(_UNIT_FRAME)


def frame_values(outline_m: tuple[float, float], kind: Kind) -> Float[np.ndarray, " 6"]:
    """Return the channels of an outline about the origin, along the axes of the world.

    A site or a building may lie across these axes, by as many quarter turns as its kind has.

    Args:
        outline_m: Sides along east and north, m.
        kind: Kind of the token.

    Returns:
        Middle (2), cosine and sine of the heading, and logarithms of the sides.
    """
    sides_m = outline_m[::-1] if kind.turn % 2 else outline_m
    return np.array([0.0, 0.0, 1.0, 0.0, *np.log(sides_m)])
