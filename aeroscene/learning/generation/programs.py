"""Our method: tokens of a program first, then its channels by diffusion; geometry does the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aeroscene.feasibility.region import Region
from aeroscene.learning.generation.denoising import Denoising, Draft
from aeroscene.learning.generation.given import GivenPart, PlacedPart, unread_in
from aeroscene.learning.generation.proposal import OnStep, Proposal, noise_of
from aeroscene.learning.generation.redo import MOST_ROUNDS, NEARLY, Redo, RedoneProposal
from aeroscene.learning.generation.request import Request, Themes
from aeroscene.learning.program.program import N_CHANNELS
from aeroscene.learning.program.skeleton import Skeleton
from aeroscene.learning.program.statistics import ProgramExample
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.draw import draw_program
from aeroscene.learning.writer.growth import Growth
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import Writer
from aeroscene.learning.writer.stepwise import StepwiseWriter


class ProgramProposer:
    """A writer, and a denoiser for the programs that it writes."""

    def __init__(self, language: Language, writer: Writer, denoising: Denoising) -> None:
        self._language = language
        self._writer = StepwiseWriter(writer)
        self._denoising = denoising

    @property
    def themes(self) -> Themes:
        """Themes of its training scenes, by domain."""
        return self._language.themes

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> list[Proposal]:
        """Write programs by wish, then denoise all their channels at once.

        Requests that redo a region are drawn one by one, because each needs several draws.

        Args:
            requests: Scenes to make.
            wishes: Contents of each scene, with nothing left open.
            rngs: Source of each program; the first one also seeds the noise.
            on_step: Called at every step with the noisy programs.

        Raises:
            RequestError: If a given scene has objects of categories that the model never saw.
            WriterError: If the model never saw a scene of the domain or of the theme.
        """
        redone = {
            row: self._redone(request.redo, wishes[row], rngs[row], on_step)
            for row, request in enumerate(requests)
            if request.redo is not None
        }
        rest = [row for row in range(len(requests)) if row not in redone]
        # Each program has its own random numbers, so its tokens do not depend on the batch.
        drafts = [self._draft(requests[row], wishes[row], rngs[row]) for row in rest]
        denoised: list[Proposal] = []
        if drafts:
            noise = noise_of([rngs[row] for row in rest], self._denoising.device)
            denoised += self._denoising.denoise(drafts, noise, on_step)
        found = dict(zip(rest, denoised, strict=True)) | redone
        return [found[row] for row in range(len(requests))]

    def _draft(self, request: Request, wish: Wish, rng: np.random.Generator) -> Draft:
        kept = request.kept
        if kept is not None:
            return self._furnished(GivenPart.of(kept, self._language, unread_in(kept)), wish, rng)
        syntax = self._language.syntax
        growth = draw_program(self._writer, syntax, wish, rng, theme=request.theme)
        return Draft(_example(growth, wish), wish, outline_m=request.outline_m)

    def _furnished(
        self,
        part: GivenPart,
        wish: Wish,
        rng: np.random.Generator,
        region: Region | None = None,
    ) -> Draft:
        """Continue a program from given tokens, in a region only on tokens that reach into it."""
        begun = part.furnishing(self._language, wish, region)
        growth = draw_program(self._writer, self._language.syntax, wish, rng, begun)
        return Draft(_example(growth, wish), wish, PlacedPart(part, begun.place_of))

    def _redone(
        self, redo: Redo, wish: Wish, rng: np.random.Generator, on_step: OnStep | None
    ) -> RedoneProposal:
        """Draw on in a region until it has about as many objects as wished for.

        The model knows no regions. Objects of a draw that lie in the region stay, and the next draw
        goes on beside them.
        """
        scene, unread = redo.kept, unread_in(redo.kept)
        # Objects of the finished scene: those that stay, and as many new ones as wished for.
        n_wanted = len(redo.kept.objects) + wish.n_fine - redo.n_kept_fine
        noise = noise_of([rng], self._denoising.device)
        for number in range(MOST_ROUNDS):
            part = replace(GivenPart.of(scene, self._language, unread), first_id=redo.first_id)
            draft = self._furnished(part, wish, rng, redo.region)
            # Only the first draw is shown; the others would repeat the same steps.
            seen = on_step if number == 0 else None
            (proposal,) = self._denoising.denoise([draft], noise, seen)
            scene = redo.kept_in(scene, proposal.scene(scene.scene_id, scene.seed, rng))
            n_short = n_wanted - len(scene.objects)
            if n_short <= NEARLY * (n_wanted - len(redo.kept.objects)):
                break
        return RedoneProposal(scene)


def _example(growth: Growth, wish: Wish) -> ProgramExample:
    """Return a drawn program, without channels as yet."""
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
