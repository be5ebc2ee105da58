"""The data of a table: training scenes for all methods, and test scenes that none has seen.

Layouts of other projects come as the user's own file, because their licences do not let us ship
them. They are mapped to our categories first, so that all methods learn from the same scenes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from aeroscene.corpus.dataset import open_dataset
from aeroscene.layouts.mapping import match, unknown_category
from aeroscene.layouts.neutral_format import read_neutral
from aeroscene.layouts.scene_cache import count_layouts, mapped_scenes
from aeroscene.metrics.appearance.frechet import LEAST_PICTURES
from aeroscene.scene import Scene, SceneError
from aeroscene.scene.io import scene_to_json

DataName = Literal["corpus", "front3d", "procthor", "city"]
_TEST_EVERY = 5
"""Every fifth layout of a file is a test scene, because such files have no splits."""


class EvaluationError(SceneError):
    """A table cannot be made; the message names the option, its value and what is valid."""


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
        """True if the scenes are those of our grammar."""
        return self.name == "corpus"


def count_scenes(name: DataName, path: Path | None) -> int:
    """Return the number of scenes that `open_data` reads, for a progress bar.

    Args:
        name: Name of the data.
        path: Folder or file of the data; None for the default of the corpus.

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
        name: Name of the data, which the table states.
        path: Folder that `aeroscene dataset build` has made, for the corpus, or the user's own file
            of neutral layouts.
        on_scene: Called after each scene.
        room: Value of `attributes.room_type` that layouts must have; None takes all.

    Returns:
        Scenes of both splits, with a digest of all.

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
                # Quoted, since the names come from a file and may have spaces.
                known = ", ".join(sorted({repr(each) for each in rooms if each})) or "no --room"
                raise EvaluationError(f"room {room!r} is none of {str(where)!r}; valid: {known}")
            scenes = [scene for scene, own in zip(scenes, rooms, strict=True) if own == room]
        # By place and not by chance, so that every table of a file has the same splits.
        test = scenes[_TEST_EVERY - 1 :: _TEST_EVERY]
        train = [scene for i, scene in enumerate(scenes) if (i + 1) % _TEST_EVERY]
    for split, found in (("train", train), ("test", test)):
        if len(found) < LEAST_PICTURES:
            raise EvaluationError(
                f"data {name} in {str(where)!r} has {len(found)} scenes of the {split} split; "
                f"valid: {LEAST_PICTURES} or more"
            )
    # Scenes after mapping: a change of the categories is a change of the data.
    digest = hashlib.sha256()
    for scene in (*train, *test):
        digest.update(scene_to_json(scene))
    return Data(name, train, test, digest.hexdigest()[:16])


def _known_rooms(path: Path) -> list[str | None]:
    """Return the type of room of each layout of a file.

    A layout with an object of an unknown category is refused, because its scene would lack it.
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
