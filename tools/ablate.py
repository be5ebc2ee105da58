"""Measure what each choice of the model brings: one row for each, switched alone.

python tools/ablate.py --data corpus --out ablation                      # all rows: hours
python tools/ablate.py --data corpus --out ablation --no-train           # of what is trained
python tools/ablate.py --data corpus --out ablation --rows default no_fourier ddim_20

Each choice in training has a small denoiser of its own, trained for equally many steps into
OUT/ROW; `aeroscene train --config --parts denoiser --out OUT/ROW` makes the same. Choices in
sampling are switched on the weights that ship. All rows place the same programs of the test
split with the same noise. What is trained or measured already is not done again. Written to
OUT/ablation.json and OUT/ablation.md.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import torch
import tyro
from ablation.measure import Case, Model, measure
from ablation.rows import SAMPLED, TRAINED, Row, SampledRow, TrainedRow
from ablation.store import Outcome, outcome_key, read_outcome, write_outcome
from ablation.table import Line, line, markdown_table, plain, rich_table
from ablation.train import Trainer

from aeroscene.corpus.dataset import open_dataset
from aeroscene.files import replacing
from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.training.config import require
from aeroscene.scene import SceneError
from scenarios.cli.progress import progress_bar
from scenarios.cli.terminal import terminal


@dataclass(frozen=True, kw_only=True)
class AblateCfg:
    """Train, sample and judge the rows."""

    data: Path = Path("corpus")
    """Folder of the corpus that `aeroscene dataset build` has made."""
    out: Path = Path("ablation")
    """Folder for the rows."""
    checkpoint: Path = SHIPPED["default"]
    """Weights on which sampling is switched."""
    steps: int = 600
    """Steps of each training."""
    scenes: int = 24
    """Scenes of the test split that are laid out."""
    rows: tuple[str, ...] = ()
    """Rows by name, and what they are held against. [default: all]"""
    train: bool = True
    """Train what is missing; without, rows that are not trained are left out."""
    precision: Literal["auto", "single", "mixed"] = "auto"
    """Precision of the trainings; mixed is faster on processors with units for bfloat16."""
    threads: int = 1
    """Threads of the processor."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print the figures as one JSON object instead of tables."""


class Ablation:
    """Rows under way."""

    def __init__(self, cfg: AblateCfg) -> None:
        self._cfg = cfg
        self._trainer = Trainer(
            data=cfg.data, out=cfg.out, steps=cfg.steps, precision=cfg.precision
        )
        self._dataset = open_dataset(cfg.data)

    def trained(self, row: TrainedRow) -> Outcome | None:
        """Outcome of a row of the training, None where it is not trained."""
        checkpoint = self._trainer.found(row)
        if checkpoint is None and self._cfg.train:
            checkpoint = self._trainer.train(row)
        if checkpoint is None:
            return None
        model = Model.of(checkpoint)
        cases = model.cases(self._dataset, self._cfg.scenes)
        path = self._cfg.out / row.name / "outcome.json"
        key = outcome_key(model.digest, cases, "default")
        known = read_outcome(path, key)
        if known is not None:
            return known
        with progress_bar(row.name, len(cases)) as advance:
            outcome = Outcome(
                key=key,
                scenes=measure(model.denoising(), cases, 0, advance),
                step_cpu_s=model.step_cpu_s(cases),
            )
        write_outcome(path, outcome)
        return outcome

    def sampled(self, row: SampledRow) -> Outcome:
        """Outcome of a row of the sampling."""
        model, cases = self._shipped
        denoising = model.denoising(**row.sampler)
        path = self._cfg.out / "sampling" / f"{row.name}.json"
        key = outcome_key(model.digest, cases, (sorted(row.sampler.items()), row.noise))
        known = read_outcome(path, key)
        if known is not None:
            return known
        with progress_bar(row.name, len(cases)) as advance:
            outcome = Outcome(key=key, scenes=measure(denoising, cases, row.noise, advance))
        write_outcome(path, outcome)
        return outcome

    @cached_property
    def _shipped(self) -> tuple[Model, list[Case]]:
        model = Model.of(read_checkpoint(self._cfg.checkpoint))
        return model, model.cases(self._dataset, self._cfg.scenes)


def main(cfg: AblateCfg) -> None:
    """Measure the rows, print and write them."""
    require(ok=cfg.steps >= 1, name="steps", value=cfg.steps, valid="1 or more")
    require(ok=cfg.scenes >= 2, name="scenes", value=cfg.scenes, valid="2 or more")
    names = _chosen(cfg.rows)
    torch.set_num_threads(cfg.threads)
    ablation = Ablation(cfg)
    cfg.out.mkdir(parents=True, exist_ok=True)
    trainings = [(row, ablation.trained(row)) for row in TRAINED if row.name in names]
    samplings = [(row, ablation.sampled(row)) for row in SAMPLED if row.name in names]
    tables = {
        f"{cfg.steps} steps of training each": _lines(trainings),
        "The shipped weights": _lines(samplings),
    }
    _write(cfg.out, tables)
    if cfg.json:
        print(json.dumps({title: plain(lines) for title, lines in tables.items()}))
        return
    for title, lines in tables.items():
        if lines:
            terminal().print(rich_table(f"{title}, {cfg.scenes} test scenes", lines))


def _chosen(names: Sequence[str]) -> set[str]:
    """Names of the rows, with those that they are held against."""
    against = {row.name: row.against for row in (*TRAINED, *SAMPLED)}
    strange = [name for name in names if name not in against]
    require(ok=not strange, name="rows", value=" ".join(strange), valid=", ".join(against))
    chosen = set(names or against)
    return chosen | {against[name] for name in chosen}


def _lines(outcomes: Sequence[tuple[Row, Outcome | None]]) -> list[Line]:
    by_name = {row.name: outcome for row, outcome in outcomes}
    return [
        line(row, outcome, None if row.against == row.name else by_name[row.against])
        for row, outcome in outcomes
        if outcome is not None
    ]


def _write(folder: Path, tables: dict[str, list[Line]]) -> None:
    document = {title: plain(lines) for title, lines in tables.items()}
    with replacing(folder / "ablation.json") as file:
        file.write(json.dumps(document, indent=1).encode())
    pages = (f"{title}\n\n{markdown_table(lines)}" for title, lines in tables.items() if lines)
    with replacing(folder / "ablation.md") as file:
        file.write("\n".join(pages).encode())


if __name__ == "__main__":
    try:
        main(tyro.cli(AblateCfg, description=__doc__))
    except (SceneError, OSError) as error:
        sys.exit(f"ablate: error: {error}")
    except KeyboardInterrupt:
        sys.exit("ablate: stopped; the same command goes on from here")
