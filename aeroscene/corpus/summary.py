"""Summaries of scenes, and sets of scenes that have one for each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Sequence
from pathlib import Path
from typing import Literal, Protocol, TypeVar

import msgspec

from aeroscene.corpus.corpus import scene_split
from aeroscene.scene import Scene, SceneDomain

Split = Literal["train", "test"]


class SceneSummary(msgspec.Struct, frozen=True, kw_only=True):
    """Facts about a scene that are known without opening it."""

    index: int
    """Number of the scene in its set, from 0; it decides on the split."""
    scene_id: str
    split: Split
    domain: SceneDomain
    n_objects: int
    n_coarse: int
    n_fine: int
    n_small: int
    """Number of landing areas whose largest class of drone is small."""
    n_medium: int
    n_large: int
    n_perching: int

    @property
    def n_landing(self) -> int:
        """Number of landing areas of all classes; perching areas are not among them."""
        return self.n_small + self.n_medium + self.n_large


Entry = TypeVar("Entry", bound=SceneSummary)


class SceneSet(Protocol[Entry]):
    """Scenes that are read one by one: a dataset in a folder, or the scenes that ship.

    Metrics and the learner take any set; a set is cheap to pass to other processes, because it
    holds summaries only.
    """

    @property
    def title(self) -> str:
        """Name of the set in a sentence, such as "corpus" or "folder"."""
        ...

    @property
    def place(self) -> Path:
        """Folder or file that holds the set, for messages."""
        ...

    @property
    def entries(self) -> Sequence[Entry]:
        """Summaries of the scenes, in the order of their numbers."""
        ...

    def select(self, indices: Container[int]) -> SceneSet[Entry]:
        """Select scenes by their numbers; with none, all that a process needs to read."""
        ...

    def read(self, entry: Entry) -> Scene:
        """Read and validate one scene.

        Raises:
            SceneError: If it cannot be read.
        """
        ...


def summarise(scene: Scene, index: int) -> SceneSummary:
    """Summarise a scene.

    Args:
        scene: The scene, with its areas.
        index: Its number in the set, which decides on the split.
    """
    n_coarse = sum(obj.is_coarse for obj in scene.objects)
    n_landing = Counter(area.drone_class for area in scene.landing_areas)
    return SceneSummary(
        index=index,
        scene_id=scene.scene_id,
        split=scene_split(index),
        domain=scene.domain,
        n_objects=len(scene.objects),
        # A counter gives 0 for a class that no area has.
        n_coarse=n_coarse,
        n_fine=len(scene.objects) - n_coarse,
        n_small=n_landing["small"],
        n_medium=n_landing["medium"],
        n_large=n_landing["large"],
        n_perching=len(scene.perching_areas),
    )
