"""Scenes that follow the first stretch: made by the grammar, encoded, kept in files for a resume.

This is what a worker process does, so nothing here needs PyTorch.
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
"""Scene, and what it has, to example of a vocabulary and statistics that it carries along.

It is pickled once for each worker process; raises `UnencodableError` where a scene has no example.
"""


@dataclass(frozen=True, slots=True)
class Fresh:
    """A scene of the stream."""

    number: int
    example: Any
    """None where the scene is skipped."""
    reason: str = ""
    """Why it is."""


def numbers_after(last: int) -> Iterator[int]:
    """Numbers of the training split beyond a number, without end."""
    return (number for number in count(last + 1) if scene_split(number) == "train")


def scene_file(folder: Path, number: int) -> Path:
    """File that keeps a scene in the folder of a training; other sources have other files."""
    return folder / FOLDER / f"{number}-{curation_digest()}.json.gz"


def fresh_example(encode: Encoder, folder: Path, number: int) -> Fresh:
    """Scene of a number as an example: from its file where there is one, else made now.

    Its areas are not derived, which would take four fifths of the time: nothing is learned of
    them but how many there are, and it counts as having as many as it may. A file that cannot be
    written costs time on a resume, not the scene.
    """
    scene = _scene(folder, number)
    wish = replace(Wish.of(scene), n_areas=most_landing_areas(number))
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
        pass
    scene = curate_layout(number)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_scene(scene, path)
    except OSError:
        pass
    return scene
