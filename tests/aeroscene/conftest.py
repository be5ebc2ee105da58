"""Corpus scenes, curated once for all tests of the package."""

from __future__ import annotations

from functools import cache

import pytest

from aeroscene.curation import curate_scene
from aeroscene.scene import Scene

SAMPLE = (7, 42, 45, 49, 311, 1015)
"""Corpus scenes that tests look at closely: outdoor, mixed, mixed, outdoor, indoor, outdoor."""

cached_scene = cache(curate_scene)


@pytest.fixture(params=SAMPLE, ids=lambda index: f"scene{index}")
def scene(request: pytest.FixtureRequest) -> Scene:
    """One of the sampled scenes."""
    return cached_scene(request.param)


@pytest.fixture(scope="session")
def scenes() -> list[Scene]:
    """All sampled scenes."""
    return [cached_scene(index) for index in SAMPLE]


@pytest.fixture(scope="session")
def scene_42() -> Scene:
    """The scene that documents speak of."""
    return cached_scene(42)
