"""Ours: the tokens of a program first, then its channels by diffusion, then geometry alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.diffusion.loss import Denoiser
from aeroscene.learning.diffusion.sampling import Fixed, Moment, SamplerCfg, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.given import GivenPart
from aeroscene.learning.generation.proposal import OnStep, noise_of
from aeroscene.learning.generation.request import Request
from aeroscene.learning.program import Program, decode
from aeroscene.learning.program.batch import channels_in, program_batch, slots_of
from aeroscene.learning.program.program import COS, N_CHANNELS, SIN, SIZE, U, V
from aeroscene.learning.program.statistics import ProgramExample, from_example
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from aeroscene.learning.writer.draw import draw_program
from aeroscene.learning.writer.growth import Growth
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import Writer
from aeroscene.scene import Scene

_SITE_FRAME: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
_UNIT_FRAME: tuple[int, ...] = (U, V, COS, SIN, SIZE.start, SIZE.start + 1)
"""Channels of middle, heading and log sides: of a site's record, and of a unit."""


@dataclass(frozen=True, eq=False)
class ProgramProposal:
    """A program with its channels."""

    example: ProgramExample
    language: Language
    given: GivenPart | None = None

    @property
    def program(self) -> Program:
        """The program, given tokens as they were given."""
        known = self.language
        program = from_example(self.example, known.vocabulary, known.statistics)
        return program if self.given is None else self.given.imposed_on(program)

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """The scene as decoded, without areas; `rng` draws the looks."""
        program = self.language.vocabulary.with_looks(self.program, rng)
        decoded = decode(program, scene_id, seed)
        return decoded.scene if self.given is None else self.given.restored_in(decoded)


class ProgramProposer:
    """A writer and a denoiser of what it writes."""

    def __init__(
        self,
        language: Language,
        writer: Writer,
        denoiser: Denoiser,
        schedule: Schedule,
        sampler: SamplerCfg,
        device: torch.device,
    ) -> None:
        self._language = language
        self._writer = writer
        self._denoiser = denoiser
        self._schedule = schedule
        self._sampler = sampler
        self._device = device
        statistics = language.statistics
        self._range = tuple(
            torch.as_tensor(each, dtype=torch.float32, device=device)
            for each in (statistics.low, statistics.high)
        )

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> list[ProgramProposal]:
        """Programs by wish, then the diffusion of all their channels at once.

        Raises:
            RequestError: If a scene to complete has objects of categories that the model never
                saw, or no program.
            WriterError: If the model never saw a scene of the domain.
        """
        given = [
            None if request.kept is None else GivenPart.of(request.kept, self._language)
            for request in requests
        ]
        written = [
            self._write(wish, rng, part)
            for wish, rng, part in zip(wishes, rngs, given, strict=True)
        ]
        return self.denoise(requests, wishes, given, written, noise_of(rngs, self._device), on_step)

    def _write(
        self, wish: Wish, rng: np.random.Generator, given: GivenPart | None
    ) -> ProgramExample:
        kept = None if given is None else given.growth(self._language, wish)
        return _example(draw_program(self._writer, self._language.syntax, wish, rng, kept), wish)

    def denoise(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        given: Sequence[GivenPart | None],
        written: Sequence[ProgramExample],
        noise: torch.Generator,
        on_step: OnStep | None = None,
    ) -> list[ProgramProposal]:
        """The written programs with channels."""
        batch = program_batch(written, wishes, self._language.statistics).to(self._device)

        def proposed(x: Tensor) -> list[ProgramProposal]:
            examples = (
                channels_in(x, each, row, batch.n_coarse_slots) for row, each in enumerate(written)
            )
            pairs = zip(examples, given, strict=True)
            return [ProgramProposal(example, self._language, part) for example, part in pairs]

        watch: Callable[[Moment, Tensor, Tensor], None] | None = None
        if on_step is not None:
            watch = lambda at, x_t, _: on_step(at, proposed(x_t))  # noqa: E731
        low, high = (each[batch.kind] for each in self._range)
        x0 = sample(
            self._denoiser,
            batch,
            self._schedule,
            self._sampler,
            noise,
            fixed=self._fixed(requests, given, written, batch),
            x0_range=(low, high),
            on_step=watch,
        )
        return proposed(x0)

    def _fixed(
        self,
        requests: Sequence[Request],
        given: Sequence[GivenPart | None],
        written: Sequence[ProgramExample],
        batch: TokenBatch,
    ) -> Fixed | None:
        """Channels of a given coarse part, or those that an outline decides."""
        mask = np.zeros((*batch.mask.shape, N_CHANNELS), dtype=bool)
        x0 = np.zeros(mask.shape, dtype=np.float32)
        for row, (request, part, example) in enumerate(zip(requests, given, written, strict=True)):
            slots = slots_of(example.skeleton, batch.n_coarse_slots)
            if part is not None:
                mask[row, slots[: part.n_tokens]] = True
                x0[row, slots[: part.n_tokens]] = part.example.x0[: part.n_tokens]
            elif request.outline_m is not None:
                place, channels, values = self._frame(example, request.outline_m)
                mask[row, slots[place], channels] = True
                x0[row, slots[place], channels] = values
        if not mask.any():
            return None
        return Fixed(*(torch.from_numpy(array).to(self._device) for array in (mask, x0)))

    def _frame(
        self, example: ProgramExample, outline_m: tuple[float, float]
    ) -> tuple[int, list[int], Float[np.ndarray, " 6"]]:
        """Token and channels that have an outline: of the site, or of the building without one."""
        kinds = self._language.vocabulary.kinds
        numbers = example.skeleton.kind_id.tolist()
        nodes = [kinds[number].node for number in numbers]
        if "site" in nodes:
            place, channels = nodes.index("site"), list(_SITE_FRAME)
        else:
            bearers = [
                int(example.skeleton.parent[i]) for i, node in enumerate(nodes) if node == "storey"
            ]
            place, channels = next((i for i in bearers if nodes[i] == "unit"), 0), list(_UNIT_FRAME)
        statistics, number = self._language.statistics, numbers[place]
        values = np.array([0.0, 0.0, 1.0, 0.0, *np.log(outline_m)])
        scaled = (values - statistics.mean[number, channels]) / statistics.spread[number, channels]
        return place, channels, np.where(statistics.is_free[number, channels], scaled, 0.0)


def _example(growth: Growth, wish: Wish) -> ProgramExample:
    """A drawn program, as yet without channels."""
    choices = growth.choices
    return ProgramExample(
        skeleton=Skeleton(
            wish.domain, np.array(growth.kinds), np.array(growth.parents), growth.n_coarse
        ),
        member=np.array([choice.member for choice in choices]),
        host=np.array([choice.host for choice in choices]),
        shape=np.array([choice.shape for choice in choices]),
        x0=np.zeros((len(choices), N_CHANNELS)),
    )
