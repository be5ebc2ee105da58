"""`bench generate`: cost and quality of generated scenes, before and after feasibility.

Every figure stands beside that of real scenes, which the same code measures on the corpus. Times
are wall times from a seed to a finished scene, landing areas and validation included.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.corpus.corpus import scene_domain
from aeroscene.learning.generation.generator import Generated, Generator
from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.generation.request import Request
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.scene import Scene
from scenarios.bench.configs import BenchError, GenerateBenchCfg
from scenarios.bench.quality import (
    FEASIBLE,
    RAW,
    TEST,
    Drawn,
    comparison,
    feasibility_rows,
    statistics_rows,
    validity_rows,
)
from scenarios.bench.reference import Splits, group_figures, open_corpus
from scenarios.bench.row import OnProgress, Row, higher, lower

MOST_SECONDS = {"default": 2.0, "paper": 3.0, "progressive": 3.0}
"""Time limit of one scene on two cores, s, by preset."""
MOST_GPU_SECONDS = 0.5
LEAST_GPU_RATE = 50.0
MOST_MEMORY_GB = {"default": 0.66, "paper": 2.0, "progressive": 2.0}
LEAST_VALID = {"cpu": 85.0, "gpu": 95.0}
"""Least percentage of valid objects before feasibility, by the device that trained the model."""

_BATCH_SIZE = 64
_N_TIMED = 6
_N_IN_MEMORY = 8
_COMMAND = "import sys; from scenarios.cli.entry import aeroscene; sys.exit(aeroscene())"
_MEASURED = """import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"""
"""Program of a small process that starts the measured one. Linux counts the memory of the process
that starts another into the peak of the latter, and this one here is large."""


def rows(cfg: GenerateBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Generate scenes one by one and judge them.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called before each part.

    Raises:
        SceneError: If checkpoint, device or corpus cannot be used.
    """
    # Opened first, so that a missing corpus is refused before minutes of work.
    corpus = open_corpus(cfg.data)
    generator = Generator.load(cfg.checkpoint, preset=cfg.preset, device=cfg.device)
    costs = _generate(generator, cfg, on_progress)
    yield from _speed_rows(generator, cfg, costs, on_progress)
    on_progress("reading the corpus", 0.6)
    real = Splits.from_corpus(corpus)
    yield from _validity_rows(cfg, costs, real.test)
    draws = [
        Drawn(raw=made.raw, projected=made.projected, is_rejected=made.scene is None)
        for made in (cost.made for cost in costs)
    ]
    # Counts the calls of the callback, which gets no argument.
    checked = iter(range(1, len(draws) + 1))
    yield from feasibility_rows(
        draws,
        lambda: on_progress(
            "checking that scenes are sound", 0.7 + 0.2 * next(checked) / cfg.n_generated
        ),
    )
    # Only accepted scenes are compared after feasibility, since users never see the others.
    accepted = [draw.projected for draw in draws if not draw.is_rejected]
    groups = {RAW: [draw.raw for draw in draws], FEASIBLE: accepted}
    yield from comparison(
        group_figures(
            groups, real, cfg.seed, lambda what, share: on_progress(what, 0.9 + 0.1 * share)
        )
    )
    if accepted:
        yield from statistics_rows(accepted)


@dataclass(frozen=True, slots=True)
class _Cost:
    """Cost of one scene."""

    made: Generated
    wall_s: float
    cpu_s: float


def _generate(generator: Generator, cfg: GenerateBenchCfg, on_progress: OnProgress) -> list[_Cost]:
    on_progress("first scene, which compiles kernels", 0.0)
    # A seed that is not measured, so that nothing of the measured scenes is in a cache.
    _one(generator, _request(cfg.seed, cfg.n_generated))
    costs = []
    for number in range(cfg.n_generated):
        on_progress(f"scene {number + 1} of {cfg.n_generated}", 0.55 * number / cfg.n_generated)
        costs.append(_one(generator, _request(cfg.seed, number)))
    return costs


def _request(seed: int, number: int) -> Request:
    """Return the request for a scene; the domains take turns, as in the corpus."""
    return Request(seed=seed + number, domain=scene_domain(number))


def _one(generator: Generator, request: Request) -> _Cost:
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    (made,) = generator.generate([request])
    return _Cost(made, time.perf_counter() - wall_s, time.process_time() - cpu_s)


def _speed_rows(
    generator: Generator, cfg: GenerateBenchCfg, costs: Sequence[_Cost], on_progress: OnProgress
) -> Iterator[Row]:
    is_gpu = _is_gpu(generator.device)
    wall_s, n_objects = [c.wall_s for c in costs], [len(c.made.raw.objects) for c in costs]
    most_s = MOST_GPU_SECONDS if is_gpu and cfg.preset == "default" else MOST_SECONDS[cfg.preset]
    median_s = float(np.median(wall_s))
    yield lower("one scene, median", median_s, "s", most_s)
    yield lower("one scene, p95", float(np.quantile(wall_s, 0.95)), "s")
    yield lower("its CPU time, median", float(np.median([c.cpu_s for c in costs])), "CPU s")
    on_progress("timing the stages", 0.55)
    stages = _stages(generator, costs)
    yield lower("its program, median", stages.program_s, "s")
    yield lower("its sampling, median", stages.sampling_s, "s")
    yield lower("its feasibility, areas and validation, median", stages.rest_s, "s")
    yield higher("its objects, mean", float(np.mean(n_objects)), "objects")
    if is_gpu:
        yield from _gpu_rows(generator, cfg, stages.rest_s)
    on_progress("measuring the memory of a command by itself", 0.6)
    # The limit is for a command on the CPU.
    most_gb = None if is_gpu else MOST_MEMORY_GB[cfg.preset]
    yield lower("peak memory", _peak_memory_gb(cfg), "GB", most_gb)


@dataclass(frozen=True, slots=True)
class _Stages:
    """Median times of the stages of a few scenes."""

    program_s: float
    sampling_s: float
    """Time of sampling the geometry; the paper's method has no other stage before feasibility."""
    rest_s: float


def _stages(generator: Generator, costs: Sequence[_Cost]) -> _Stages:
    """Measure the stages of a few scenes, which are generated once more with an observer."""
    measured = [_stages_of(generator, cost) for cost in costs[:_N_TIMED]]
    return _Stages(*np.median(measured, axis=0).tolist())


def _stages_of(generator: Generator, cost: _Cost) -> tuple[float, float, float]:
    """Return the seconds of the program, of the sampling and of the rest.

    The observer is called at the end of each denoising step. The end of the program is therefore
    estimated: the first step is taken to last as long as the median of the others.
    """
    seen_s = [time.perf_counter()]
    list(
        generator.generate(
            [cost.made.request], on_step=lambda *_: seen_s.append(time.perf_counter())
        )
    )
    rest_s = time.perf_counter() - seen_s[-1]
    step_s = float(np.median(np.diff(seen_s[1:])))
    sampling_s = step_s + seen_s[-1] - seen_s[1]
    return max(0.0, seen_s[1] - seen_s[0] - step_s), sampling_s, rest_s


def _gpu_rows(generator: Generator, cfg: GenerateBenchCfg, rest_s: float) -> Iterator[Row]:
    """Generate many scenes at once, and subtract the processor's time after sampling."""
    import torch

    requests = [_request(cfg.seed, number) for number in range(_BATCH_SIZE)]
    start_s = time.perf_counter()
    n_made = sum(1 for _ in generator.generate(requests, batch_size=_BATCH_SIZE))
    wall_s = time.perf_counter() - start_s
    # The floor keeps rounding from making the time zero or negative.
    model_s = max(wall_s - n_made * rest_s, 1e-3)
    least = LEAST_GPU_RATE if cfg.preset == "default" else None
    yield higher(f"sampling in batches of {_BATCH_SIZE}", n_made / model_s, "scenes / s", least)
    yield higher("the same with feasibility", n_made / wall_s, "scenes / s")
    memory_gb = torch.cuda.max_memory_allocated() / 1e9
    yield lower("peak memory of the GPU", memory_gb, "GB")


def _validity_rows(
    cfg: GenerateBenchCfg, costs: Sequence[_Cost], test: Sequence[Scene]
) -> Iterator[Row]:
    facts = read_checkpoint(cfg.checkpoint or SHIPPED[cfg.preset]).facts
    trained_on = "gpu" if _is_gpu(str(facts.training.get("device", "cpu"))) else "cpu"
    yield from validity_rows([c.made.raw for c in costs], RAW, LEAST_VALID[trained_on])
    yield from validity_rows(test[: len(costs)], TEST, None)


def _is_gpu(device: str) -> bool:
    return not device.startswith("cpu")


def _peak_memory_gb(cfg: GenerateBenchCfg) -> float:
    """Return the peak memory of an `aeroscene generate` that makes a few of the scenes.

    A process of its own, because this one also holds the corpus and its figures.

    Raises:
        BenchError: If it fails.
    """
    asked = {"preset": cfg.preset, "device": cfg.device, "seed": cfg.seed, "count": _N_IN_MEMORY}
    chosen = asked if cfg.checkpoint is None else {**asked, "checkpoint": cfg.checkpoint}
    options = [word for name, value in chosen.items() for word in (f"--{name}", str(value))]
    command = [sys.executable, "-c", _COMMAND, "generate", *options]
    with tempfile.TemporaryDirectory(prefix="aeroscene-generate-") as folder:
        run = subprocess.run(  # noqa: S603 - arguments are ours
            [sys.executable, "-c", _MEASURED, *command, "--out", folder],
            capture_output=True,
            text=True,
            check=False,
        )
    if run.returncode:
        raise BenchError(f"aeroscene generate failed: {' '.join(command[3:])}")
    peak = int(run.stdout)
    # Kilobytes on Linux, bytes on macOS.
    return peak / 1e9 if sys.platform == "darwin" else peak * 1024 / 1e9
