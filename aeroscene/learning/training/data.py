"""Training data: the corpus in a folder, or a file of neutral layouts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from aeroscene.corpus.dataset import open_dataset
from aeroscene.layouts.kept import count_layouts, mapped_scenes
from aeroscene.learning.paper.tokens import FlatTrainingSet, encode_flat, flat_training_set
from aeroscene.learning.tokens.codec import DEFAULT_CODEC, CodecCfg
from aeroscene.learning.tokens.examples import encode
from aeroscene.learning.tokens.kinds import Vocabulary, count_kinds
from aeroscene.learning.tokens.skeleton import Skeleton, Wish, skeleton_of
from aeroscene.learning.tokens.training_set import TrainingSet, training_set
from aeroscene.learning.training.checkpoint import DataSource
from aeroscene.learning.training.config import TrainingError
from aeroscene.scene import Scene

_HELD_OUT_EVERY = 10
"""Every so many scenes of a layout file, which has no splits, one is held out."""
_LEAST_SCENES = 2
_MOST_WISHES = 256

OnScene = Callable[[], None]
Set = TrainingSet | FlatTrainingSet


@dataclass(frozen=True)
class TrainingData:
    """Scenes to train on, and others to watch the training by."""

    source: DataSource
    vocabulary: Vocabulary
    skeletons: tuple[tuple[Skeleton, Wish], ...]
    """Skeletons of the scenes to train on, with what each has."""
    train: Set
    held_out: Set
    """Scenes that are not trained on, those of them whose kinds occur in training."""


def open_training_data(
    path: Path,
    *,
    is_flat: bool = False,
    codec: CodecCfg = DEFAULT_CODEC,
    on_scene: OnScene = lambda: None,
) -> TrainingData:
    """Read what a user names.

    Args:
        path: Folder of a dataset, whose training split is taken; or a file of neutral layouts.
        is_flat: As the paper has scenes, objects beside each other in the scene's frame; otherwise
            as trees, each object in the frame of its parent.
        codec: Codec of a tree's channels.
        on_scene: Called after each scene.

    Raises:
        SceneError: If there is no such data, or it is not valid.
    """
    train, held_out = _scenes(path, on_scene)
    if len(train) < _LEAST_SCENES:
        raise TrainingError(
            f"data {str(path)!r} has {len(train)} scenes to train on, "
            f"valid: {_LEAST_SCENES} or more"
        )
    wishes = [Wish.of(scene) for scene in train] if is_layouts(path) else []
    return prepared(path.name, train, held_out, is_flat=is_flat, codec=codec, wishes=wishes)


def prepared(
    name: str,
    train: Sequence[Scene],
    held_out: Sequence[Scene],
    *,
    is_flat: bool = False,
    codec: CodecCfg = DEFAULT_CODEC,
    wishes: Sequence[Wish] = (),
) -> TrainingData:
    """Scenes as tokens, to train on and to watch by.

    A checkpoint names them as `name`, and draws what it is asked for from `wishes` where there are
    any.
    """
    tree = training_set(train, codec)
    vocabulary = count_kinds(train)
    sample = tuple(wishes[:: 1 + len(wishes) // _MOST_WISHES])
    source = DataSource(name=name, digest=tree.digest, n_scenes=len(train), wishes=sample)
    skeletons = tuple((skeleton_of(scene, vocabulary), Wish.of(scene)) for scene in train)
    known = flat_training_set(train) if is_flat else tree
    return TrainingData(source, vocabulary, skeletons, known, _encoded(held_out, known))


def _scenes(path: Path, on_scene: OnScene) -> tuple[list[Scene], list[Scene]]:
    if is_layouts(path):
        return _layout_scenes(path, on_scene)
    dataset = open_dataset(path)
    train: list[Scene] = []
    held_out: list[Scene] = []
    for entry in dataset.entries:
        (train if entry.split == "train" else held_out).append(dataset.read(entry))
        on_scene()
    return train, held_out


def count_scenes(path: Path) -> int:
    """Number of the scenes that `open_training_data` reads.

    Raises:
        SceneError: If there is no such data.
    """
    return count_layouts(path) if is_layouts(path) else len(open_dataset(path).entries)


def is_layouts(path: Path) -> bool:
    """Whether a user names a file of layouts, not the folder of a dataset."""
    return path.is_file() or ".jsonl" in path.name


def _layout_scenes(path: Path, on_scene: OnScene) -> tuple[list[Scene], list[Scene]]:
    scenes = mapped_scenes(path, on_scene)
    held_out = scenes[_HELD_OUT_EVERY - 1 :: _HELD_OUT_EVERY]
    train = [scene for i, scene in enumerate(scenes) if (i + 1) % _HELD_OUT_EVERY]
    return train, held_out


def _encoded(scenes: Sequence[Scene], known: Set) -> Set:
    if isinstance(known, FlatTrainingSet):
        examples = tuple(encode_flat(scene, known.statistics) for scene in scenes)
        return FlatTrainingSet(known.statistics, examples)
    found = []
    for scene in scenes:
        try:
            found.append(encode(scene, known.vocabulary, known.statistics))
        except KeyError:
            continue  # An object of a kind that no scene of the training split has.
    return TrainingSet(known.vocabulary, known.statistics, tuple(found))
