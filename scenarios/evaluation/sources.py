"""The data of a table: training scenes that methods are given, test scenes that none has seen."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from aeroscene.corpus.dataset import open_dataset
from aeroscene.layouts.kept import count_layouts, mapped_scenes
from aeroscene.layouts.mapping import match, unknown_category
from aeroscene.layouts.neutral import read_neutral
from aeroscene.metrics.appearance.frechet import LEAST_PICTURES
from aeroscene.scene import Scene, SceneError
from aeroscene.scene.io import scene_to_json

DataName = Literal["corpus", "front3d", "procthor", "city"]
_TEST_EVERY = 5
"""Every so many layouts of a file, which has no splits, one is a test scene."""


class EvaluationError(SceneError):
    """A table that cannot be made; one line with the option, the value and what is valid."""


@dataclass(frozen=True, eq=False)
class Data:
    """Scenes in two splits."""

    name: DataName
    train: Sequence[Scene]
    test: Sequence[Scene]
    digest: str
    """Sixteen hexadecimal digits that differ between sets of scenes."""

    @property
    def is_corpus(self) -> bool:
        """Whether the scenes are our grammar's."""
        return self.name == "corpus"


def count_scenes(name: DataName, path: Path | None) -> int:
    """Number of scenes that `open_data` reads.

    Raises:
        SceneError: If there is no such data.
    """
    where = _place(name, path)
    return len(open_dataset(where).entries) if name == "corpus" else count_layouts(where)


def open_data(
    name: DataName,
    path: Path | None,
    on_scene: Callable[[], None] = lambda: None,
    room: str | None = None,
) -> Data:
    """Read the data of a table.

    Args:
        name: Which data it is; the table is called after it.
        path: Folder that `aeroscene dataset build` has made, for the corpus, or the user's own file
            of neutral layouts.
        on_scene: Called after each scene.
        room: Only layouts whose `attributes.room_type` is this.

    Raises:
        SceneError: If there is no such data, or too little of it.
    """
    where = _place(name, path)
    if name == "corpus":
        splits: dict[str, list[Scene]] = {"train": [], "test": []}
        dataset = open_dataset(where)
        for entry in dataset.entries:
            splits[entry.split].append(dataset.read(entry))
            on_scene()
        train, test = splits["train"], splits["test"]
    else:
        rooms = _known_rooms(where)
        scenes = mapped_scenes(where, on_scene)
        if room is not None:
            if room not in rooms:
                known = ", ".join(sorted({repr(each) for each in rooms if each})) or "no --room"
                raise EvaluationError(f"room {room!r} is none of {str(where)!r}; valid: {known}")
            scenes = [scene for scene, own in zip(scenes, rooms, strict=True) if own == room]
        test = scenes[_TEST_EVERY - 1 :: _TEST_EVERY]
        train = [scene for i, scene in enumerate(scenes) if (i + 1) % _TEST_EVERY]
    for split, found in (("train", train), ("test", test)):
        if len(found) < LEAST_PICTURES:
            raise EvaluationError(
                f"data {name} in {str(where)!r} has {len(found)} scenes of the {split} split; "
                f"valid: {LEAST_PICTURES} or more"
            )
    digest = hashlib.sha256()
    for scene in (*train, *test):
        digest.update(scene_to_json(scene))
    return Data(name, train, test, digest.hexdigest()[:16])


def _known_rooms(path: Path) -> list[str | None]:
    """The type of room of each layout of a file.

    Layouts with things that are in none of our categories are refused: scenes would lack them.
    """
    rooms: list[str | None] = []
    for layout in read_neutral(path):
        room = layout.attributes.get("room_type")
        rooms.append(room if isinstance(room, str) else None)
        for number, obj in enumerate(layout.objects):
            if match(obj) is None:
                unknown = unknown_category(obj.category)
                raise EvaluationError(f"scene {layout.scene_id!r}: object {number}: {unknown}")
    return rooms


def _place(name: DataName, path: Path | None) -> Path:
    if path is not None:
        return path
    if name == "corpus":
        return Path("corpus")
    raise EvaluationError(
        f"data {name} has no path; valid: --path FILE with neutral layouts of it "
        "(docs/layouts.md); we ship none of them"
    )
