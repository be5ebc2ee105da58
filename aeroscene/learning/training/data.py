"""Training data: the corpus in a folder, or a file of neutral layouts.

The training split fixes vocabulary and statistics. Held-out scenes, and later those of a stream,
are encoded with them and never extend them, because the shapes of the networks depend on them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from aeroscene.corpus.dataset import DatasetError, open_dataset
from aeroscene.corpus.provenance import curation_digest
from aeroscene.layouts.scene_cache import mapped_scenes
from aeroscene.learning.paper.training_set import FlatTrainingSet, flat_training_set
from aeroscene.learning.program import WHOLE, EncodingCfg
from aeroscene.learning.symmetry import may_be_mirrored, mirrored
from aeroscene.learning.training.batches.curation import Encoder
from aeroscene.learning.training.checkpoint_facts import FLAT_PRESETS, DataSource
from aeroscene.learning.training.config import Preset, TrainingError
from aeroscene.learning.training.data_named import is_layouts
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.examples import ProgramEncoder, UnencodableError, encodable, written
from aeroscene.learning.writer.language import Language, learn_language
from aeroscene.learning.writer.training_set import ProgramSet
from aeroscene.scene import Scene

_HELD_OUT_EVERY = 10
"""One scene in so many is held out from a layout file, which has no splits."""
_LEAST_SCENES = 2
# Wishes that a checkpoint keeps, at most.
_MOST_WISHES = 256

OnScene = Callable[[], None]
Set = ProgramSet | FlatTrainingSet


@dataclass(frozen=True)
class TrainingData:
    """Scenes to train on, and others on which the training is measured."""

    source: DataSource
    train: Set
    held_out: Set
    """Held-out scenes that can be encoded."""
    n_skipped: int = 0
    """Number of held-out scenes that cannot be encoded."""
    last_number: int | None = None
    """Number after which the grammar continues with training scenes; None without a stream."""


def open_training_data(
    path: Path,
    *,
    preset: Preset = "default",
    is_streamed: bool = False,
    language: Language | None = None,
    on_scene: OnScene = lambda: None,
) -> TrainingData:
    """Read the data that a user names.

    Args:
        path: Folder of a dataset, whose training split is taken; or a file of neutral layouts.
        preset: Programs for the default one; lists of boxes for the paper's two.
        is_streamed: True lets the grammar continue where the dataset ends. The scenes in the folder
            are then the first stretch: it fixes vocabulary and statistics, and its test split is
            held out.
        language: Language of the programs; None learns it from the training split.
        on_scene: Called after each scene.

    Raises:
        SceneError: If there is no such data, or it is not valid.
    """
    last = _last_number(path) if is_streamed else None
    train, held_out = training_scenes(path, on_scene)
    if len(train) < _LEAST_SCENES:
        raise TrainingError(
            f"data {str(path)!r} has {len(train)} scenes to train on; "
            f"valid: {_LEAST_SCENES} or more"
        )
    is_corpus = not is_layouts(path)
    # In the paper the number of objects is drawn; only layouts of others need
    # the wishes of their scenes.
    is_flat = preset in FLAT_PRESETS
    wishes = [] if is_flat and is_corpus else [Wish.from_scene(scene) for scene in train]
    data = prepared(
        path.name,
        train,
        held_out,
        preset=preset,
        wishes=wishes,
        is_corpus=is_corpus,
        language=language,
    )
    if last is None:
        return data
    source = msgspec.structs.replace(data.source, stream=f"{curation_digest()} from {last + 1}")
    return replace(data, source=source, last_number=last)


def prepared(
    name: str,
    train: Sequence[Scene],
    held_out: Sequence[Scene],
    *,
    preset: Preset = "default",
    wishes: Sequence[Wish] = (),
    is_corpus: bool = True,
    encoding: EncodingCfg = WHOLE,
    language: Language | None = None,
) -> TrainingData:
    """Encode scenes, to train on and to measure on.

    The training scenes fix how scenes are encoded, unless a `language` does. Their `encoder`
    encodes the held-out scenes here, and the scenes of a stream in the worker processes.

    Args:
        name: Name of the data in the checkpoint.
        train: Scenes to train on.
        held_out: Scenes to measure on.
        preset: Preset that is trained.
        wishes: Contents from which a checkpoint draws open fields of requests; may be empty.
        is_corpus: True draws landing areas as the corpus does.
        encoding: Details of scenes that programs keep.
        language: Language of the programs; None learns it.

    Raises:
        TrainingError: If too few scenes have a program.
    """
    known = (
        flat_training_set(train, has_regions=preset == "progressive")
        if preset in FLAT_PRESETS
        else _program_set(_varied(train, is_corpus=is_corpus), encoding, language)
    )
    if len(known.examples) < _LEAST_SCENES:
        raise TrainingError(
            f"data {name!r} has {len(known.examples)} scenes that have a program; "
            f"valid: {_LEAST_SCENES} or more"
        )
    examples = _encoded(held_out, known.encoder)
    return TrainingData(
        source=DataSource(
            name=name,
            digest=known.digest,
            n_scenes=len(known.examples),
            # An even sample of the wishes keeps the checkpoint small.
            wishes=tuple(wishes[:: 1 + len(wishes) // _MOST_WISHES]),
            is_corpus=is_corpus,
        ),
        train=known,
        held_out=known.with_examples(examples),
        n_skipped=len(held_out) - len(examples),
    )


def _varied(scenes: Sequence[Scene], *, is_corpus: bool) -> Sequence[Scene]:
    """Add the mirror images of training scenes; their programs differ from the originals'.

    Turned scenes have the same programs, so they add nothing. The corpus needs neither, because its
    grammar makes more scenes.
    """
    if is_corpus:
        return scenes
    return [*scenes, *(mirrored(scene) for scene in scenes if may_be_mirrored(scene.domain))]


def _program_set(
    scenes: Sequence[Scene], encoding: EncodingCfg, language: Language | None
) -> ProgramSet:
    if language is not None:
        return ProgramSet(language, tuple(_encoded(scenes, ProgramEncoder(language))))
    encoded, wishes = encodable(scenes, encoding)
    if not encoded:
        raise TrainingError(
            "none of the scenes has a program; valid: scenes whose floors, walls "
            "and covers do not overlap"
        )
    language = learn_language(encoded, encoding)
    pairs = zip(encoded, wishes, strict=True)
    return ProgramSet(language, tuple(written(each, wish, language) for each, wish in pairs))


def _last_number(path: Path) -> int:
    """Return the number of the last scene of a folder that the present grammar has made."""
    if is_layouts(path):
        raise TrainingError(
            f"data {str(path)!r} is a file of layouts, of which no grammar makes more, valid with "
            "--stream: a folder that aeroscene dataset build has made"
        )
    entries = open_dataset(path).entries
    n_foreign = sum(entry.sources != curation_digest() for entry in entries)
    if n_foreign:
        raise DatasetError(
            f"{n_foreign} of {len(entries)} scenes in {str(path)!r} were made by other sources "
            "than those that would follow, valid with --stream: scenes of this very code; "
            "aeroscene dataset build makes them again"
        )
    return entries[-1].index


def training_scenes(
    path: Path, on_scene: OnScene = lambda: None
) -> tuple[list[Scene], list[Scene]]:
    """Read the training scenes and the held-out scenes of the data that a user names.

    Args:
        path: Folder of a dataset, or a file of neutral layouts.
        on_scene: Called after each scene.

    Raises:
        SceneError: If there is no such data, or it is not valid.
    """
    if is_layouts(path):
        return _layout_scenes(path, on_scene)
    dataset = open_dataset(path)
    train: list[Scene] = []
    held_out: list[Scene] = []
    # In order of the manifest, which decides the order of the examples and thereby the digest.
    for entry in dataset.entries:
        (train if entry.split == "train" else held_out).append(dataset.read(entry))
        on_scene()
    return train, held_out


def _layout_scenes(path: Path, on_scene: OnScene) -> tuple[list[Scene], list[Scene]]:
    scenes = mapped_scenes(path, on_scene)
    held_out = scenes[_HELD_OUT_EVERY - 1 :: _HELD_OUT_EVERY]
    train = [scene for i, scene in enumerate(scenes) if (i + 1) % _HELD_OUT_EVERY]
    return train, held_out


def _encoded(scenes: Sequence[Scene], encode: Encoder) -> list[Any]:
    found: list[Any] = []
    for scene in scenes:
        with suppress(UnencodableError):
            found.append(encode(scene, Wish.from_scene(scene)))
    return found
