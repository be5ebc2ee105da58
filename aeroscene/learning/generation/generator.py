"""The trained model at work: a request becomes a proposal, and the proposal a feasible scene.

The same request gives the same scene on the same device with the same batch size. Therefore every
seed has three independent streams of random numbers: for what the request leaves open, for the
model, and for looks. A rejected draw takes the next number of `attempt` and new streams.
"""

# ruff: noqa: E402 - a missing torch is reported in our words before an import below fails on it.
from __future__ import annotations

from aeroscene.learning import require_torch

require_torch()

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from aeroscene.areas.landing import AreaLimits
from aeroscene.corpus.corpus import scene_domain
from aeroscene.feasibility import FeasibilityReport
from aeroscene.learning.generation.loading import load_proposer
from aeroscene.learning.generation.proposal import OnStep, Proposal, Proposer
from aeroscene.learning.generation.request import Request, Themes
from aeroscene.learning.generation.sense import senseless
from aeroscene.learning.program import DecodingCfg
from aeroscene.learning.training.devices import choose_device, naming_memory
from aeroscene.learning.wishes import Wish
from aeroscene.scene import Scene

MOST_ATTEMPTS = 8
"""Draws of a seed before it is given up."""


class NoFeasibleSceneError(RuntimeError):
    """Every draw was rejected; one line has the last reason."""


@dataclass(frozen=True)
class Generated:
    """A generated scene with the stages that led to it."""

    request: Request
    attempt: int
    """Number of this draw, from 0. `sound_scene` rejected all draws before it."""
    proposal: Proposal
    """The model's proposal."""
    raw: Scene
    """The scene as sampled, without areas."""
    projected: Scene
    """The scene after the projection, with areas."""
    report: FeasibilityReport
    wish: Wish
    """Contents on which the model was conditioned: wishes of the request, and the rest as drawn."""

    @property
    def scene(self) -> Scene | None:
        """The finished scene; None if it was rejected as infeasible or by `senseless`."""
        return None if self.report.rejection else self.projected


class _Drawn(NamedTuple):
    """A request with nothing left open, and the model's proposal for it."""

    proposal: Proposal
    wish: Wish
    limits: AreaLimits | None
    """Greatest numbers of areas."""
    rng: np.random.Generator
    """Source of strewn objects and looks."""


class Generator:
    """Makes scenes from seeds."""

    def __init__(
        self, proposer: Proposer, device: str, seen: Sequence[Wish] = (), *, is_corpus: bool = True
    ) -> None:
        """Set up the model.

        Args:
            proposer: The model.
            device: Device on which it computes.
            seen: Contents of its training scenes, from which requests are drawn.
            is_corpus: True if scenes get at most as many areas as the corpus draws for each.
        """
        self._proposer = proposer
        self._seen, self._is_corpus = tuple(seen), is_corpus
        # Other data may have lots that no road leads to, and so has the paper's model, which has no
        # themes: their scenes are not rejected for it.
        self._makes_places = is_corpus and bool(proposer.themes)
        self.device = device

    @staticmethod
    def load(
        checkpoint: Path | None = None,
        *,
        preset: str = "default",
        device: str = "auto",
        n_steps: int | None = None,
        changes: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
        decoding: DecodingCfg | None = None,
    ) -> Generator:
        """Read a trained model.

        Args:
            checkpoint: File that `aeroscene train` has written; None is the one that ships.
            preset: Preset of the checkpoint that ships; not read if `checkpoint` is given.
            device: As `aeroscene.learning.training.devices.choose_device` takes it.
            n_steps: Denoising steps; None are the preset's.
            changes: New values of fields of its configuration that sampling reads, by section.
            decoding: Corrections of drawn programs; None makes all of them.

        Raises:
            SceneError: If checkpoint or device cannot be used.
        """
        where = choose_device(device)
        proposer, data = load_proposer(
            checkpoint, preset, where, n_steps, changes=changes, decoding=decoding
        )
        return Generator(proposer, str(where), data.wishes, is_corpus=data.is_corpus)

    @property
    def themes(self) -> Themes:
        """Themes that the model knows, by domain."""
        return self._proposer.themes

    def check(self, request: Request) -> None:
        """Refuse a request that the model cannot follow, before anything is made.

        Raises:
            RequestError: If it was trained on no scene of this domain or theme.
        """
        request.alike(self._seen, self._proposer.themes)

    def generate(
        self,
        requests: Sequence[Request],
        *,
        batch_size: int = 1,
        attempt: int = 0,
        on_step: OnStep | None = None,
    ) -> Iterator[Generated]:
        """Make one scene for each request, and yield each as it is finished, rejected ones too.

        Args:
            requests: Scenes to make.
            batch_size: Scenes that are denoised at once. On a processor one by one is as fast.
            attempt: Number of the draw; another number gives another scene of the same request.
            on_step: Sees every step of the denoising.

        Raises:
            DeviceError: If memory runs out.
            RequestError: If a request cannot be met.
        """
        # A batch at a time, so that the caller sees scenes as they are finished.
        for start in range(0, len(requests), batch_size):
            chunk = requests[start : start + batch_size]
            for request, drawn in zip(chunk, self._proposed(chunk, attempt, on_step), strict=True):
                yield self._finish(request, attempt, drawn)

    def sampled(self, request: Request, *, attempt: int = 0) -> Scene:
        """Return the scene of a request as sampled, before feasibility.

        This is `Generated.raw`, but the projection, which takes longer, is not done.

        Raises:
            DeviceError: If memory runs out.
            RequestError: If the request cannot be met.
            SceneError: If a number is not finite.
        """
        (drawn,) = self._proposed([request], attempt, None)
        return _raw(drawn.proposal, request, drawn.rng)

    def _proposed(
        self, requests: Sequence[Request], attempt: int, on_step: OnStep | None
    ) -> list[_Drawn]:
        """Fill in what the requests leave open, and let the model propose their scenes together."""
        streams = [_streams(request, attempt) for request in requests]
        themes = self._proposer.themes
        drawn = [
            r.drawn(rngs[0], self._seen, themes, is_corpus=self._is_corpus)
            for r, rngs in zip(requests, streams, strict=True)
        ]
        with naming_memory(choose_device(self.device), f"fewer than {len(requests)} at once"):
            proposals = self._proposer.propose(
                requests, [wish for wish, _ in drawn], [rngs[1] for rngs in streams], on_step
            )
        return [
            _Drawn(proposal, wish, limits, rngs[2])
            for proposal, (wish, limits), rngs in zip(proposals, drawn, streams, strict=True)
        ]

    def sound_scene(self, request: Request, on_step: OnStep | None = None) -> Generated:
        """Draw until a scene is feasible.

        Args:
            request: Scene to make.
            on_step: Sees every step of the denoising, of rejected draws too.

        Raises:
            NoFeasibleSceneError: If `MOST_ATTEMPTS` draws were rejected.
            DeviceError: If memory runs out.
            RequestError: If the request cannot be met.
        """
        reason: str | None = None
        for attempt in range(MOST_ATTEMPTS):
            generated = next(self.generate([request], attempt=attempt, on_step=on_step))
            reason = generated.report.rejection
            if reason is None:
                return generated
        raise NoFeasibleSceneError(
            f"seed {request.seed}: {MOST_ATTEMPTS} draws were rejected, the last because {reason}; "
            "valid: another seed, or fewer objects"
        )

    def _finish(self, request: Request, attempt: int, drawn: _Drawn) -> Generated:
        raw = _raw(drawn.proposal, request, drawn.rng)
        feasible = request.projected(raw, drawn.rng, drawn.limits)
        report = feasible.report
        # A scene to complete has its lots and bridges from its owner: those
        # are no reason to reject it.
        if report.rejection is None and request.kept is None and self._makes_places:
            report = replace(report, rejection=senseless(feasible.scene))
        return Generated(request, attempt, drawn.proposal, raw, feasible.scene, report, drawn.wish)


def _raw(proposal: Proposal, request: Request, rng: np.random.Generator) -> Scene:
    return proposal.scene(f"aeroscene-{request.seed:04d}", request.seed, rng)


def generate_scene(seed: int) -> Scene:
    """Make the scene of a seed by the model that ships, on the processor.

    Successive seeds take the domains in turn.

    Raises:
        SceneError: If the checkpoint is missing.
        NoFeasibleSceneError: If no draw is feasible.
    """
    found = _shipped().sound_scene(Request(seed=seed, domain=scene_domain(seed))).scene
    assert found is not None
    return found


@cache
def _shipped() -> Generator:
    return Generator.load(device="cpu")


def _streams(request: Request, attempt: int) -> list[np.random.Generator]:
    """Three sources of randomness: for the wish, for the model and for the looks."""
    # A region that is drawn anew with its scene's own seed must not come out as it was.
    numbers = (request.seed, attempt) if request.redo is None else (request.seed, attempt, 1)
    streams = np.random.SeedSequence(numbers).spawn(3)
    return [np.random.default_rng(stream) for stream in streams]
