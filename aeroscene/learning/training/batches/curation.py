"""Scenes after the first stretch: made by the grammar, encoded, and kept in files for a resume.

Worker processes run this module, so nothing here needs PyTorch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

from aeroscene.corpus.corpus import scene_split
from aeroscene.corpus.curation import curate_layout, most_landing_areas
from aeroscene.corpus.provenance import curation_digest
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.examples import UnencodableError
from aeroscene.scene import Scene, SceneError
from aeroscene.scene.io import read_scene, write_scene

FOLDER = "stream"

Encoder = Callable[[Scene, Wish], Any]
"""Function from a scene and its wish to an example, which carries vocabulary and statistics along.
It is pickled once for each worker process, and raises `UnencodableError` for a scene that has no
example."""


@dataclass(frozen=True, slots=True)
class Fresh:
    """A scene of the stream."""

    number: int
    example: Any
    """Its example; None if the scene is skipped."""
    reason: str = ""
    """Reason for skipping it."""


def numbers_after(last: int) -> Iterator[int]:
    """Yield the numbers of the training split beyond a number, without end."""
    return (number for number in count(last + 1) if scene_split(number) == "train")


def scene_file(folder: Path, number: int) -> Path:
    """Return the file that keeps a scene in the folder of a training.

    Its name contains a digest of the grammar's sources, so that other sources have other files.
    """
    return folder / FOLDER / f"{number}-{curation_digest()}.json.gz"


def fresh_example(encode: Encoder, folder: Path, number: int) -> Fresh:
    """Return the example of a scene: from its file if there is one, else made now.

    Its landing areas are not derived, which would take four fifths of the time. Only their number
    is learned, and the scene counts as having as many as it may. If the file cannot be written, a
    resume takes longer, but the scene is not lost.
    """
    scene = _scene(folder, number)
    # The areas are not derived; their greatest number stands for them.
    wish = replace(Wish.from_scene(scene), n_areas=most_landing_areas(number))
    try:
        example = encode(scene, wish)
    except UnencodableError as error:
        return Fresh(number, None, str(error))
    return Fresh(number, example)


def _scene(folder: Path, number: int) -> Scene:
    path = scene_file(folder, number)
    try:
        return read_scene(path)
    except SceneError:
        # No file yet, or a damaged one: make the scene.
        pass
    scene = curate_layout(number)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_scene(scene, path)
    except OSError:
        pass
    return scene
