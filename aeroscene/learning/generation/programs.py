"""Ours: the tokens of a program first, then its channels by diffusion, then geometry alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aeroscene.learning.generation.denoising import Denoising, Draft, ProgramProposal
from aeroscene.learning.generation.given import GivenPart
from aeroscene.learning.generation.proposal import OnStep, noise_of
from aeroscene.learning.generation.request import Request, Themes
from aeroscene.learning.program.program import N_CHANNELS
from aeroscene.learning.program.statistics import ProgramExample
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from aeroscene.learning.writer.draw import draw_program
from aeroscene.learning.writer.growth import Growth
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import Writer


class ProgramProposer:
    """A writer, and the denoising of what it writes."""

    def __init__(self, language: Language, writer: Writer, denoising: Denoising) -> None:
        self._language = language
        self._writer = writer
        self._denoising = denoising

    @property
    def themes(self) -> Themes:
        """Themes of the scenes that it was trained on."""
        return self._language.themes

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
            WriterError: If the model never saw a scene of the domain, or of the theme.
        """
        given = [
            None if request.kept is None else GivenPart.of(request.kept, self._language)
            for request in requests
        ]
        drafts = [self._draft(*each) for each in zip(requests, wishes, rngs, given, strict=True)]
        noise = noise_of(rngs, self._denoising.device)
        return self._denoising.denoise(drafts, noise, on_step)

    def _draft(
        self, request: Request, wish: Wish, rng: np.random.Generator, given: GivenPart | None
    ) -> Draft:
        kept = None if given is None else given.growth(self._language, wish)
        growth = draw_program(self._writer, self._language.syntax, wish, rng, kept, request.theme)
        return Draft(_example(growth, wish), wish, given, request.outline_m)


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
