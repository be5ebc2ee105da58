"""Corpus of a few scenes in a folder, each stored several times."""

from itertools import count, islice

from aeroscene.corpus.corpus import scene_split
from aeroscene.corpus.dataset import store_scene, write_manifest
from aeroscene.metrics.classifier import N_FOLDS
from tests.aeroscene.conftest import SAMPLE, cached_scene, renamed


def write_corpus(folder, n_train=N_FOLDS, n_test=N_FOLDS):
    """Store the given number of scenes of each split."""
    (folder / "scenes").mkdir(parents=True)
    numbers = [
        number
        for split, wanted in (("train", n_train), ("test", n_test))
        for number in islice((i for i in count() if scene_split(i) == split), wanted)
    ]
    write_manifest(
        folder,
        [
            store_scene(
                folder,
                renamed(cached_scene(SAMPLE[number % len(SAMPLE)]), f"corpus-{number:04d}"),
                number,
            )
            for number in sorted(numbers)
        ],
    )
    return folder
