"""Seeds of random streams: of a run's seed, the scene and the name of the stream together.

Two streams that differ in any of the three are independent: what one flight draws says nothing of
another one's draws, in the same scene or with the same seed elsewhere.
"""

from __future__ import annotations

import hashlib

import numpy as np


def seed_sequence(seed: int, scene_id: str, *stream: str | int) -> np.random.SeedSequence:
    """Seed of one random stream.

    Args:
        seed: Seed of the run.
        scene_id: Name of the scene.
        stream: Name of the stream, in one or more parts.
    """
    name = "\n".join([scene_id, *map(str, stream)])
    words = np.frombuffer(hashlib.blake2b(name.encode(), digest_size=16).digest(), dtype="<u4")
    entropy = [seed, *words.tolist()]
    # numpy takes twice as long for a list, of which it makes the same array.
    return np.random.SeedSequence(np.array(entropy, np.uint32) if seed < 2**32 else entropy)


def generator(seed: int, scene_id: str, *stream: str | int) -> np.random.Generator:
    """Generator of one random stream; for the arguments see `seed_sequence`."""
    return np.random.default_rng(seed_sequence(seed, scene_id, *stream))
