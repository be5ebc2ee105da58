"""Corpus scenes, curated once for all tests of the package."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from aeroscene.corpus.curation import curate_scene
from aeroscene.corpus.shipped import Provenance, write_archive
from aeroscene.scene import Scene

SAMPLE = (7, 42, 45, 49, 311, 1015)
"""Corpus scenes that tests look at closely: outdoor, mixed, mixed, outdoor, indoor, outdoor."""

cached_scene = cache(curate_scene)


@cache
def sampled_scenes() -> list[Scene]:
    """The sampled scenes, made when a test asks: every process of a run imports every test."""
    return [cached_scene(index) for index in SAMPLE]


@pytest.fixture(params=SAMPLE, ids=lambda index: f"scene{index}")
def scene(request: pytest.FixtureRequest) -> Scene:
    """One of the sampled scenes."""
    return cached_scene(request.param)


@pytest.fixture(scope="session")
def scenes() -> list[Scene]:
    """All sampled scenes."""
    return sampled_scenes()


@pytest.fixture(scope="session")
def scene_42() -> Scene:
    """The scene that documents speak of."""
    return cached_scene(42)


def renamed(scene: Scene, scene_id: str) -> Scene:
    """The same scene under another name."""
    members = tuple(replace(obj, scene_id=scene_id) for obj in scene.objects)
    return replace(scene, scene_id=scene_id, objects=members)


N_ARCHIVED = 19


@pytest.fixture(scope="session")
def provenance() -> Provenance:
    """What an archive may say of its scenes."""
    return Provenance(
        generator="curation",
        checkpoint="",
        code="0.1.0+0123456789abcdef",
        environment={"numpy": "2.2.0"},
        attempts={3: 2},
    )


@pytest.fixture(scope="session")
def archived_scenes() -> list[Scene]:
    """Scenes of an archive: the sampled ones under new names."""
    return [
        renamed(cached_scene(SAMPLE[i % len(SAMPLE)]), f"aeroscene-{i:04d}")
        for i in range(N_ARCHIVED)
    ]


@pytest.fixture(scope="session")
def archive_path(
    tmp_path_factory: pytest.TempPathFactory,
    archived_scenes: list[Scene],
    provenance: Provenance,
) -> Path:
    """An archive of them."""
    path = tmp_path_factory.mktemp("shipped") / "scenes.zip"
    assert write_archive(path, archived_scenes, provenance) == path.stat().st_size
    return path
