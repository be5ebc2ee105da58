"""`bench method`: gates that the network of the paper's presets has to pass.

A loss alone does not show whether a network has learnt anything. For a channel by itself, with a
variance v, the best linear guess of its noise needs no network:

    eps = sigma x_t / (alpha_bar v + sigma^2)

    symbol          name
    x_t             noisy channel at time t
    alpha_bar       share of the signal's variance at t
    sigma           standard deviation of the noise at t
    eps             unit noise that was added

A network that is worse than this formula has learned nothing in that channel, whatever its loss is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import torch

from aeroscene.learning.diffusion.sampling import sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.guidance.layout import FlatReader
from aeroscene.learning.paper.guidance.objectives import Objectives
from aeroscene.learning.paper.guidance.semantic import SemanticPrior
from aeroscene.learning.paper.network.layout_denoiser import LayoutDenoiser
from aeroscene.learning.paper.network.trust import GROUPS, formula, noisy, time_of
from aeroscene.learning.paper.training_set import FlatTrainingSet
from aeroscene.learning.training.checkpoint import Checkpoint, read_checkpoint
from aeroscene.learning.training.data import prepared, training_scenes
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.paper_preset import paper_sampler
from aeroscene.learning.training.presets import sections_from_plain
from scenarios.bench.configs import BenchError, MethodBenchCfg
from scenarios.bench.memorisation import memorising_rows
from scenarios.bench.row import OnProgress, Row, higher, lower

NOISE_TO_SIGNAL = (30.0, 4.0, 1.0, 0.3, 0.1, 0.03, 0.01)
"""Ratios sigma / sqrt(alpha_bar) at which errors are measured."""
MOST_RATIO = 1.0
MOST_HEADING_DEG = 3.0
_GUIDED_AT = 0.1
_BATCH = 16
_SEED = 5


def rows(cfg: MethodBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Judge a checkpoint, then learn eight scenes.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called before each part.

    Raises:
        SceneError: If checkpoint or data cannot be used.
        BenchError: If the checkpoint is of another preset.
    """
    on_progress("reading the scenes", 0.0)
    torch.set_num_threads(1)
    checkpoint = read_checkpoint(cfg.checkpoint or SHIPPED[cfg.preset])
    if checkpoint.facts.preset != cfg.preset:
        raise BenchError(
            f"checkpoint {str(cfg.checkpoint)!r} is of preset {checkpoint.facts.preset!r}, valid "
            f"with --preset {cfg.preset}: one of the same"
        )
    train, held_out = training_scenes(cfg.data)
    scenes = prepared(cfg.data.name, train, held_out, preset=cfg.preset).held_out
    assert isinstance(scenes, FlatTrainingSet)
    # Every other held-out scene has fitted the network's trust, so the others must judge it.
    judged_on = scenes.examples[1::2][: cfg.count]
    judged = _Judged(checkpoint, scenes.with_examples(judged_on))
    on_progress("holding the network against the formula", 0.1)
    yield from judged.ratio_rows()
    on_progress("drawing the geometry of held-out contents", 0.3)
    yield judged.heading_row()
    yield from judged.guidance_rows()
    if cfg.cpu_seconds > 0:
        on_progress("learning eight scenes by heart, twice", 0.5)
        yield from memorising_rows(cfg.preset, train, cfg.cpu_seconds)


class _Judged:
    """A trained network, with scenes that it has not seen."""

    def __init__(self, checkpoint: Checkpoint, scenes: FlatTrainingSet) -> None:
        known = checkpoint.known
        assert isinstance(known, FlatStatistics)
        sections = sections_from_plain(checkpoint.facts.configs)
        self._schedule = Schedule(sections["schedule"])
        network = new_denoiser(sections["model"], known, self._schedule)
        assert isinstance(network, LayoutDenoiser)
        checkpoint.load_into(network, "denoiser")
        self._network = network.eval()
        prior = SemanticPrior(sections["prior"])
        checkpoint.load_into(prior, "prior")
        self._read = FlatReader(known)
        is_hollow = torch.from_numpy(known.holds)
        self._objectives = Objectives(self._read, sections["guidance"], prior.eval(), is_hollow)
        self._sampler = replace(
            paper_sampler(has_regions=bool(known.has_regions)),
            parameterisation=sections["loss"].parameterisation,
        )
        # The network's inputs are scaled by the checkpoint's statistics, not by these scenes' own.
        scenes = replace(scenes, statistics=known)
        starts = range(0, len(scenes.examples), _BATCH)
        self._batches = [scenes.in_order(start, _BATCH) for start in starts]

    def ratio_rows(self) -> Iterator[Row]:
        """Yield squared errors over the formula's, for each group of channels: worst and mean."""
        found = [self._ratios(ratio) for ratio in NOISE_TO_SIGNAL]
        for name in GROUPS:
            values = [ratios[name] for ratios in found if name in ratios]
            worst = int(np.argmax(values))
            at = f"at noise by signal {NOISE_TO_SIGNAL[worst]:g}"
            metric = f"error of {name} by the formula's"
            yield lower(f"{metric}, worst, {at}", values[worst], "", MOST_RATIO)
            yield lower(f"{metric}, mean", float(np.mean(values)), "")

    def _ratios(self, noise_to_signal: float) -> dict[str, float]:
        time = time_of(self._schedule, noise_to_signal)
        # The same noise for every checkpoint, so that their figures can be compared.
        generator = torch.Generator().manual_seed(_SEED)
        sums = {name: np.zeros(2) for name in GROUPS}
        for batch in self._batches:
            x_t, eps, is_free = noisy(batch, self._schedule, time, generator)
            with torch.no_grad():
                output = self._network(x_t, time.expand(len(x_t)), batch).output
            variance = self._network.variance[batch.kind]
            guesses = output, formula(x_t, time, variance, self._schedule)
            for name, channels in GROUPS.items():
                for k, guess in enumerate(guesses):
                    error = ((guess - eps).square() * is_free)[..., channels]
                    sums[name][k] += float(error.sum())
        # A group of channels that these scenes leave empty has no error to compare.
        return {name: float(own / formula) for name, (own, formula) in sums.items() if formula}

    def heading_row(self) -> Row:
        """Return the mean error of drawn headings, given contents and quarter turns of a scene."""
        generator = torch.Generator().manual_seed(_SEED)
        off_deg = []
        for batch in self._batches:
            x0 = sample(
                self._network,
                batch,
                self._schedule,
                self._sampler,
                generator,
                guidance=self._objectives,
            )
            assert batch.x0 is not None
            assert batch.given is not None
            drawn, real = self._read(x0, batch).heading, self._read(batch.x0, batch).heading
            cosine = (drawn * real).sum(-1).clamp(-1, 1)
            off_deg.append(cosine.arccos().rad2deg()[batch.mask & ~batch.given])
        mean_deg = float(torch.cat(off_deg).mean())
        return lower("heading off, given the quarter turn, mean", mean_deg, "deg", MOST_HEADING_DEG)

    def guidance_rows(self) -> Iterator[Row]:
        """Yield the share of each objective in the lengths of the steps that guidance takes.

        An objective with a tiny share has no effect, whatever its weight says.
        """
        time = time_of(self._schedule, _GUIDED_AT)
        generator = torch.Generator().manual_seed(_SEED)
        lengths: dict[str, float] = {}
        for batch in self._batches:
            x_t, _, is_free = noisy(batch, self._schedule, time, generator)
            with torch.no_grad():
                eps = self._network(x_t, time.expand(len(x_t)), batch).output
            alpha, sigma = self._schedule.signal_and_noise(time)
            # The clean layout that the predicted noise implies; guidance works on it.
            x0 = (x_t - sigma * eps) / alpha * is_free
            for name, step in self._objectives.steps(x0, batch).items():
                lengths[name] = lengths.get(name, 0.0) + float(step.norm(dim=-1).sum())
        total = sum(lengths.values()) or 1.0
        for name, length in lengths.items():
            yield higher(f"share of {name} in the steps of guidance", 100 * length / total, "%")
