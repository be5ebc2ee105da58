"""Data that a user names for a training: its kind and its size, without PyTorch."""

from __future__ import annotations

from pathlib import Path

from aeroscene.corpus.dataset import open_dataset
from aeroscene.layouts.neutral_format import read_neutral
from aeroscene.layouts.scene_cache import count_layouts


def require_data(path: Path) -> None:
    """Refuse a path that holds no training data.

    A folder is checked by its manifest, a file of layouts by every layout in it.

    Raises:
        SceneError: If there is no such data, or it is not valid.
    """
    if not is_layouts(path):
        open_dataset(path)
        return
    for _ in read_neutral(path):
        pass


def count_scenes(path: Path) -> int:
    """Return the number of scenes that `open_training_data` reads.

    Raises:
        SceneError: If there is no such data.
    """
    return count_layouts(path) if is_layouts(path) else len(open_dataset(path).entries)


def is_layouts(path: Path) -> bool:
    """True if a path names a file of layouts, not the folder of a dataset."""
    return path.is_file() or ".jsonl" in path.name
