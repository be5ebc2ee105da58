"""Seeds of random streams: of a run's seed, the scene and the name of the stream together.

Two streams that differ in any of the three are independent: the draws of one flight say nothing
about those of another, in the same scene or with the same seed elsewhere. A part that draws more or
fewer numbers than before therefore changes no other part's draws, which one common generator would
do.
"""

from __future__ import annotations

import hashlib

import numpy as np


def seed_sequence(seed: int, scene_id: str, *stream: str | int) -> np.random.SeedSequence:
    """Return the seed of one random stream.

    Args:
        seed: Seed of the run, not negative.
        scene_id: Name of the scene.
        stream: Name of the stream, in one or more parts.
    """
    # A line for each part, so that ("a", "bc") and ("ab", "c") differ.
    name = "\n".join([scene_id, *map(str, stream)])
    # Not Python's hash(), which differs from run to run.
    words = np.frombuffer(hashlib.blake2b(name.encode(), digest_size=16).digest(), dtype="<u4")
    entropy = [seed, *words.tolist()]
    # numpy takes twice as long for a list, of which it makes the same array.
    return np.random.SeedSequence(np.array(entropy, np.uint32) if seed < 2**32 else entropy)


def generator(seed: int, scene_id: str, *stream: str | int) -> np.random.Generator:
    """Return the generator of one random stream.

    Args:
        seed: Seed of the run, not negative.
        scene_id: Name of the scene.
        stream: Name of the stream, in one or more parts.
    """
    return np.random.default_rng(seed_sequence(seed, scene_id, *stream))
