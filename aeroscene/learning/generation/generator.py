"""The trained model at work: what it proposes, made feasible.

The same request gives the same scene on the same device with the same batch size.
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
"""Draws until one is feasible."""


class NoFeasibleSceneError(RuntimeError):
    """Every draw was rejected; one line with the last reason."""


@dataclass(frozen=True)
class Generated:
    """A scene as it came about."""

    request: Request
    attempt: int
    """Draws before this one that were rejected, when asked for by `sound_scene`."""
    proposal: Proposal
    raw: Scene
    """The scene as sampled, without areas."""
    projected: Scene
    """After the projection, with areas."""
    report: FeasibilityReport
    wish: Wish
    """Contents that the model was told: what was asked for, and the rest as it was drawn."""

    @property
    def scene(self) -> Scene | None:
        """The finished scene, None where it was rejected: infeasible, or no place (`senseless`)."""
        return None if self.report.rejection else self.projected


class _Drawn(NamedTuple):
    """A request with nothing left open, and what the model proposes for it."""

    proposal: Proposal
    wish: Wish
    limits: AreaLimits | None
    """Greatest numbers of areas."""
    rng: np.random.Generator
    """Draws what is strewn, and the looks."""


class Generator:
    """Scenes from seeds."""

    def __init__(
        self, proposer: Proposer, device: str, seen: Sequence[Wish] = (), *, is_corpus: bool = True
    ) -> None:
        """Set up the model.

        Args:
            proposer: The model.
            device: Where it computes.
            seen: Contents of its training scenes, from which requests are drawn.
            is_corpus: Whether scenes have at most as many areas as the corpus draws for each.
        """
        self._proposer = proposer
        self._seen, self._is_corpus = tuple(seen), is_corpus
        # What learnt from others may well have lots that nothing leads to, as the paper's has.
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
            preset: Which of those that ship.
            device: As `aeroscene.learning.training.devices.choose_device` takes it.
            n_steps: Denoising steps; None are the preset's.
            changes: Fields of its configuration that sampling reads, by section, set anew.
            decoding: What is done with programs beyond reading them; None does all.

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
        """Refuse what the model cannot be asked for, before anything is made.

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
        """One scene for each request, rejected ones among them, as they are finished.

        Args:
            requests: Scenes to make.
            batch_size: Scenes that are denoised at once. On a processor one by one is as fast.
            attempt: Another draw of the same requests.
            on_step: Sees every step of the denoising.

        Raises:
            DeviceError: If memory runs out.
            RequestError: If a request cannot be met.
        """
        for start in range(0, len(requests), batch_size):
            chunk = requests[start : start + batch_size]
            for request, drawn in zip(chunk, self._proposed(chunk, attempt, on_step), strict=True):
                yield self._finish(request, attempt, drawn)

    def sampled(self, request: Request, *, attempt: int = 0) -> Scene:
        """The scene of a request as sampled, before feasibility: `Generated.raw`, in less time.

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
        """What is proposed for each request."""
        streams = [_streams(request.seed, attempt) for request in requests]
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

        Raises:
            NoFeasibleSceneError: If `MOST_ATTEMPTS` draws were rejected.
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
        if report.rejection is None and request.kept is None and self._makes_places:
            report = replace(report, rejection=senseless(feasible.scene))
        return Generated(request, attempt, drawn.proposal, raw, feasible.scene, report, drawn.wish)


def _raw(proposal: Proposal, request: Request, rng: np.random.Generator) -> Scene:
    return proposal.scene(f"aeroscene-{request.seed:04d}", request.seed, rng)


def generate_scene(seed: int) -> Scene:
    """The scene of a seed by the model that ships, on the processor; in turn of all domains.

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


def _streams(seed: int, attempt: int) -> list[np.random.Generator]:
    """Randomness for the wish, for the model and for the looks."""
    streams = np.random.SeedSequence((seed, attempt)).spawn(3)
    return [np.random.default_rng(stream) for stream in streams]
