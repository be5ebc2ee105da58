"""The corpus: how many scenes, which domain and which split each has."""

from __future__ import annotations

from typing import Literal

from aeroscene.scene import SceneDomain

CORPUS_SIZE = 1016
"""Scenes of the paper's dataset: 812 train and 204 test."""

_DOMAINS: tuple[SceneDomain, ...] = ("mixed", "outdoor", "indoor")


def scene_domain(index: int) -> SceneDomain:
    """Domain of a corpus scene: a third each."""
    return _DOMAINS[index % len(_DOMAINS)]


def scene_split(index: int) -> Literal["train", "test"]:
    """Split of a corpus scene: 812 train, 204 test, each with a third of every domain."""
    return "test" if index % 5 == 0 else "train"
