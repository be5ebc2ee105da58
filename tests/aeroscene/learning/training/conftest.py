"""Small scenes and small models, so that a training takes a second."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.training.config import Budget, TrainCfg
from aeroscene.learning.training.data import TrainingData, prepared
from aeroscene.learning.training.fitted import fitted
from aeroscene.learning.training.presets import preset_sections
from aeroscene.learning.training.procedure import Plan
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.scene import Scene
from tests.aeroscene.conftest import cached_scene

TRAIN, HELD_OUT = (7, 42, 49, 311), (42,)


def ten_objects(scene: Scene) -> Scene:
    """The first objects of a scene, parents among them."""
    return replace(scene, objects=scene.objects[:10], interaction_areas=())


@pytest.fixture(scope="session")
def small_scenes() -> list[Scene]:
    return [ten_objects(cached_scene(index)) for index in TRAIN]


@pytest.fixture(scope="session")
def data(small_scenes) -> TrainingData:
    held_out = [ten_objects(cached_scene(index)) for index in HELD_OUT]
    return prepared("small", small_scenes, held_out)


def small_sections(data: TrainingData, **training):
    sections = preset_sections("default") | {
        "model": ModelCfg(width=16, blocks=2, heads=2),
        "training": TrainCfg(batch_size=4, warmup_steps=3, **training),
        "writer": WriterCfg(width=16, kind_width=4, layers=1),
        "writer_training": TrainCfg(batch_size=2, warmup_steps=2),
    }
    return fitted(sections, data.train.known)


@pytest.fixture
def plan(data, tmp_path) -> Plan:
    return Plan(
        folder=tmp_path / "training",
        preset="default",
        sections=small_sections(data),
        data=data,
        budgets={"writer": Budget(steps=3), "denoiser": Budget(steps=8)},
        device=torch.device("cpu"),
        log_steps=2,
        parts=("writer", "denoiser"),
    )


class Watcher:
    """Looks on; stops the training after so many steps of the denoiser."""

    def __init__(self, stop_after: int | None = None, stage: str = "denoiser") -> None:
        self.seen: list[tuple[str, float]] = []
        self._stop_after = stop_after
        self._stage = stage

    def on_progress(self, stage, share, _figures) -> None:
        self.seen.append((stage, share))

    def wants_stop(self) -> bool:
        n_steps = sum(stage == self._stage for stage, _ in self.seen)
        return self._stop_after is not None and n_steps >= self._stop_after
