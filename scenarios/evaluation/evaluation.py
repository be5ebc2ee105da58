"""A table under way: methods are trained, their scenes are drawn, and everything is judged.

An evaluation works on one folder and does only what is missing there: trainings resume, existing
draws stay, and figures are read if nothing that they depend on has changed. It can therefore be
stopped at any moment, and continued with more scenes or further methods.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from aeroscene.files import replacing
from aeroscene.learning.baselines.fitting import Lessons, Spent
from aeroscene.learning.baselines.model import BaselineCfg
from aeroscene.learning.baselines.registry import Fitted
from aeroscene.learning.training.config import Budget
from aeroscene.learning.training.journal import held_out_losses, least_held_out_at
from aeroscene.metrics.appearance.features import FeatureNetwork
from aeroscene.metrics.appearance.frechet import LEAST_PICTURES
from aeroscene.metrics.scorecard import Yardstick
from aeroscene.scene import SceneDomain
from scenarios.evaluation.class_colours import ClassPictures
from scenarios.evaluation.drawing import PROJECTED, SAMPLED, STAGES, Draw, Drawer
from scenarios.evaluation.entrants import Entrant, Means
from scenarios.evaluation.renders import Camera, Photographer
from scenarios.evaluation.rows import Judge, Row, cost_rows, stage_name
from scenarios.evaluation.sources import Data, EvaluationError

_ASKED, _SPENT, _TRAINING = "asked.json", "spent.json", "training"
OnProgress = Callable[[str, float], None]
Protocol = Literal["ours", "diffuscene"]


class StoppedError(Exception):
    """The user has stopped the work and may continue it later."""


@dataclass(frozen=True, kw_only=True)
class EvaluationCfg:
    """Settings on which the scenes of a table depend; one folder has scenes of one such setting."""

    data: str
    data_digest: str
    network: str
    seed: int
    cpu_minutes: float | None
    """Budget of each method's training; None for no limit of time."""
    steps: int | None
    baseline: BaselineCfg
    protocol: Protocol
    room: str | None


class Evaluation:
    """Work on the folder of one table."""

    def __init__(
        self,
        cfg: EvaluationCfg,
        data: Data,
        network: FeatureNetwork,
        folder: Path,
        wants_stop: Callable[[], bool],
    ) -> None:
        """Open a folder, or make it.

        Args:
            cfg: Settings, which must equal those that the folder was begun with.
            data: Scenes of both splits.
            network: Network that turns pictures into features.
            folder: Folder of the table.
            wants_stop: Function that returns true once the user wants to stop.

        Raises:
            EvaluationError: If the folder holds a table of other settings.
            OSError: If it cannot be written.
        """
        self.cfg = cfg
        self._data, self._network = data, network
        self._folder, self._wants_stop = folder, wants_stop
        makes_camera = (
            ClassPictures.from_scenes if cfg.protocol == "diffuscene" else Camera.from_scenes
        )
        self.camera: Photographer = makes_camera(data.train)
        folder.mkdir(parents=True, exist_ok=True)
        path, text = folder / _ASKED, msgspec.json.format(msgspec.json.encode(cfg), indent=1)
        if path.exists() and path.read_bytes() != text:
            raise EvaluationError(
                f"out {str(folder)!r} holds a table of other data, seed, budget or sizes; valid: "
                f"those in {str(path)!r}, or another folder"
            )
        with replacing(path) as file:
            file.write(text)

    def run(
        self, entrants: Sequence[Entrant], count: int, n_flown: int, on_progress: OnProgress
    ) -> list[Row]:
        """Train, draw and judge everything that is not done yet.

        Args:
            entrants: Rows of the table, in its order.
            count: Scenes of each row; real ones are at most as many as the test split has.
            n_flown: Scenes of each row that the demo flies.
            on_progress: Called with the present step and the share of the whole work.

        Returns:
            Figures of all rows.

        Raises:
            StoppedError: If the user has stopped the work.
            SceneError: If a method cannot be trained or its scenes cannot be judged.
            OSError: If a file cannot be written.
        """
        if count < LEAST_PICTURES:
            raise EvaluationError(f"scenes is {count}; valid: {LEAST_PICTURES} or more")
        rows: list[Row] = []
        for number, entrant in enumerate(entrants):
            # Defaults bind the present entrant, since a closure would see the last one.
            def tell(what: str, share: float, done: int = number, who: Entrant = entrant) -> None:
                on_progress(f"{who.title}: {what}", (done + share) / len(entrants))

            rows += self._entrant_rows(entrant, count, n_flown, tell)
        return rows

    def draws(self, entrant: Entrant, count: int) -> list[Draw]:
        """Return the draws of an entrant that exist.

        Args:
            entrant: Row of the table.
            count: Greatest number of draws.
        """
        return list(self._drawer(entrant).drawn(self._count(entrant, count)))

    def curves(self, entrant: Entrant) -> dict[str, list[tuple[float, float]]]:
        """Return the learning curves of an entrant, by the title of each stage of its training.

        Args:
            entrant: Row of the table.

        Returns:
            CPU seconds and held-out loss at each evaluation; empty without a training.
        """
        stages = held_out_losses(self._place(entrant) / _TRAINING)
        is_whole = len(stages) == 1
        return {
            entrant.title if is_whole else f"{entrant.title}: {stage}": looks
            for stage, looks in stages.items()
        }

    def _entrant_rows(
        self, entrant: Entrant, count: int, n_flown: int, tell: OnProgress
    ) -> list[Row]:
        count = self._count(entrant, count)
        drawer = self._drawer(entrant)
        missing = drawer.missing(count)
        spent = self._spent(entrant)
        # Without missing draws no training is opened, which would load a network.
        if missing:
            # Training counts as half of a row's work, drawing as most of the rest.
            fitted = entrant.begin(self._means(lambda share: tell("training", share / 2)))
            if fitted.spent is not None and not fitted.spent.is_done:
                raise StoppedError
            self._keep_spent(entrant, fitted.spent)
            spent = fitted.spent
            self._draw(drawer, entrant, fitted, missing, tell)
        draws = list(drawer.drawn(count))
        self._fly(drawer, draws[:n_flown], tell)
        # Read again, because flights have amended the facts.
        draws = list(drawer.drawn(count))
        tell("judging", 0.95)
        rows = self._judged(entrant, draws)
        best_at = least_held_out_at(self._place(entrant) / _TRAINING)
        costs = cost_rows(
            entrant.name, draws, spent, best_at, self.cfg.seed, is_real=entrant.is_real
        )
        return rows + costs

    def _draw(
        self,
        drawer: Drawer,
        entrant: Entrant,
        fitted: Fitted,
        missing: Sequence[int],
        tell: OnProgress,
    ) -> None:
        for done, number in enumerate(missing):
            if self._wants_stop():
                raise StoppedError
            tell(f"scene {done + 1} of {len(missing)}", 0.5 + 0.4 * done / len(missing))
            # Real scenes are taken by number, whatever the seed.
            seed = number if entrant.is_real else self.cfg.seed + number
            drawer.draw(number, seed, fitted.sample, is_real=entrant.is_real)

    def _fly(self, drawer: Drawer, draws: Sequence[Draw], tell: OnProgress) -> None:
        from scenarios.baselines.named import pilot_of
        from scenarios.generation.worst_scenes import fly

        for number, draw in enumerate(draws):
            if self._wants_stop():
                raise StoppedError
            if draw.facts.lands is not None:
                continue
            tell(f"flight {number + 1} of {len(draws)}", 0.9 + 0.05 * number / len(draws))
            # A real scene has no projected stage.
            scene = draw.scene(PROJECTED) or draw.scene(SAMPLED)
            is_sound = draw.facts.failure is None and draw.facts.rejection is None
            # A draw without a sound scene counts as not landed, without being flown.
            lands = bool(is_sound and scene and fly(scene, pilot_of("demo", "pilot")).success)
            drawer.amend(draw, msgspec.structs.replace(draw.facts, lands=lands))

    def _judged(self, entrant: Entrant, draws: Sequence[Draw]) -> list[Row]:
        rows: list[Row] = []
        for stage in STAGES:
            n_there = sum(draw.features(stage) is not None for draw in draws)
            if n_there < LEAST_PICTURES and stage != SAMPLED:
                # Too few draws were not rejected, so their figures would mean nothing.
                continue
            if n_there < LEAST_PICTURES:
                raise EvaluationError(
                    f"method {entrant.name} has drawn {n_there} scenes; valid: {LEAST_PICTURES} or "
                    "more; a larger --scenes, or a longer training"
                )
            kept = self._place(entrant) / f"rows-{stage}.json"
            rows += self._judge.rows(stage_name(entrant.name, stage), stage, draws, kept)
        return rows

    # Made on first use, because photographing the training scenes takes long.
    @cached_property
    def _judge(self) -> Judge:
        return Judge(
            yardstick=Yardstick.from_scenes(self._data.train),
            pictures=self._reference_pictures(),
            views=self.camera.views,
            network=self._network,
            seed=self.cfg.seed,
            key=self._key,
        )

    @property
    def judge(self) -> Judge:
        """Judge of the table, which compares scenes with the training scenes."""
        return self._judge

    @property
    def _key(self) -> str:
        """Data, network and protocol: all that figures depend on beside the judged scenes."""
        network = f"{self._network.name} {self._network.digest}"
        return f"{self._data.digest} {network} {self.cfg.protocol}"

    def _reference_pictures(self) -> np.ndarray:
        """Return the features of the training scenes' pictures, and keep those that are made."""
        path = self._folder / "reference.npz"
        key = self._key
        found = _read_reference(path, key)
        for scene in self._data.train[len(found) :]:
            if self._wants_stop():
                _write_reference(path, key, found)
                raise StoppedError
            found.append(self._network.features(self.camera.pictures(scene)))
        _write_reference(path, key, found)
        return np.stack(found)

    def _means(self, on_share: Callable[[float], None]) -> Means:
        cfg = self.cfg
        seconds = None if cfg.cpu_minutes is None else 60.0 * cfg.cpu_minutes

        def lessons(method: str) -> Lessons:
            return Lessons(
                folder=self._folder / "methods" / method / _TRAINING,
                name=self._data.name,
                train=self._data.train,
                held_out=self._data.test,
                budget=Budget(steps=cfg.steps, seconds=seconds),
                seed=cfg.seed,
                is_corpus=self._data.is_corpus,
            )

        return Means(
            lessons=lessons,
            cfg=cfg.baseline,
            data=self._data,
            watcher=_Watcher(on_share, self._wants_stop),
        )

    def _drawer(self, entrant: Entrant) -> Drawer:
        # The draws have the same share of each domain as the test split.
        domains: list[SceneDomain] = [scene.domain for scene in self._data.test]
        folder = self._place(entrant) / "scenes"
        return Drawer(folder, self._network, self.camera, domains)

    def _place(self, entrant: Entrant) -> Path:
        return self._folder / "methods" / entrant.name

    def _count(self, entrant: Entrant, count: int) -> int:
        return min(count, len(self._data.test)) if entrant.is_real else count

    def _spent(self, entrant: Entrant) -> Spent | None:
        path = self._place(entrant) / _SPENT
        return msgspec.json.decode(path.read_bytes(), type=Spent) if path.exists() else None

    def _keep_spent(self, entrant: Entrant, spent: Spent | None) -> None:
        if spent is not None:
            with replacing(self._place(entrant) / _SPENT) as file:
                file.write(msgspec.json.encode(spent))


@dataclass(frozen=True)
class _Watcher:
    """Reports the progress of a training, and ends it if the user wants to stop."""

    on_share: Callable[[float], None]
    is_over: Callable[[], bool]

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        del stage, figures
        self.on_share(min(share, 1.0))

    def wants_stop(self) -> bool:
        return self.is_over()


def _read_reference(path: Path, key: str) -> list[np.ndarray]:
    if not path.exists():
        return []
    with np.load(path, allow_pickle=False) as file:
        # Features of another network or other scenes are made anew.
        is_ours = str(file["key"]) == hashlib.sha256(key.encode()).hexdigest()
        return list(file["features"]) if is_ours else []


def _write_reference(path: Path, key: str, found: Sequence[np.ndarray]) -> None:
    if found:
        digest = hashlib.sha256(key.encode()).hexdigest()
        with replacing(path) as file:
            np.savez_compressed(file, key=digest, features=np.stack(found))
