"""The corpus: its number of scenes, and the domain and split of each."""

from __future__ import annotations

from typing import Literal

from aeroscene.scene import SceneDomain

CORPUS_SIZE = 1016
"""Number of scenes in the paper's dataset: 812 train and 204 test."""

_DOMAINS: tuple[SceneDomain, ...] = ("mixed", "outdoor", "indoor")


def scene_domain(index: int) -> SceneDomain:
    """Domain of a corpus scene; each domain has a third of the scenes."""
    return _DOMAINS[index % len(_DOMAINS)]


def scene_split(index: int) -> Literal["train", "test"]:
    """Split of a corpus scene: 812 train, 204 test.

    Every fifth scene is a test scene. Five and three have no common divisor, so each split has a
    third of every domain.
    """
    return "test" if index % 5 == 0 else "train"
