"""Scenes as examples to learn from, in any symmetry of the square."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.learning.tokens.channels import MIRRORED, channels_of, geometry_of
from aeroscene.learning.tokens.codec import DEFAULT_CODEC, CodecCfg
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish, skeleton_of
from aeroscene.learning.tokens.statistics import Statistics, measure, standardise
from aeroscene.scene import Scene


class UnencodableError(ValueError):
    """A scene that a vocabulary and its statistics have no example for; one line that says why."""


@dataclass(frozen=True)
class Example:
    """A scene as a skeleton, the standardised channels of its tokens, and what it has."""

    skeleton: Skeleton
    wish: Wish
    x0: Float[np.ndarray, "n channels"]


def encode_corpus(
    scenes: Sequence[Scene], vocabulary: Vocabulary, codec: CodecCfg = DEFAULT_CODEC
) -> tuple[list[Example], Statistics]:
    """All scenes as tokens, and the statistics that standardise them."""
    skeletons = [skeleton_of(scene, vocabulary) for scene in scenes]
    raw = [channels_of(k, geometry_of(s), codec) for k, s in zip(skeletons, scenes, strict=True)]
    statistics = measure(vocabulary, skeletons, raw, codec)
    examples = [
        Example(skeleton, Wish.of(scene), standardise(skeleton, *channels, statistics))
        for scene, skeleton, channels in zip(scenes, skeletons, raw, strict=True)
    ]
    return examples, statistics


def encode(
    scene: Scene, vocabulary: Vocabulary, statistics: Statistics, *, allow_nearest: bool = False
) -> Example:
    """One scene as tokens; arguments and errors as those of `skeleton_of`."""
    skeleton = skeleton_of(scene, vocabulary, allow_nearest=allow_nearest)
    channels = channels_of(skeleton, geometry_of(scene), statistics.codec)
    return Example(skeleton, Wish.of(scene), standardise(skeleton, *channels, statistics))


@dataclass(frozen=True)
class TreeEncoder:
    """From scenes to examples of one vocabulary and its statistics, in whichever process."""

    vocabulary: Vocabulary
    statistics: Statistics

    def __call__(self, scene: Scene) -> Example:
        """The scene as tokens.

        Raises:
            UnencodableError: If an object is of no kind of the vocabulary.
        """
        try:
            return encode(scene, self.vocabulary, self.statistics)
        except KeyError as error:
            kind = error.args[0]
            category = getattr(kind, "category", kind)
            raise UnencodableError(f"kind {category} is unknown: {kind}") from None


def mirrored(example: Example) -> Example:
    """The scene seen in a mirror: north and south change places."""
    x0 = example.x0.copy()
    x0[:, MIRRORED] *= -1
    return Example(example.skeleton, example.wish, x0)


def quarter_turned(example: Example, codec: CodecCfg = DEFAULT_CODEC) -> Example:
    """The scene turned by 90 degrees about its middle.

    Only what stands on the site feels it; every place does that is in the frame of the scene.
    """
    x0 = example.x0.copy()
    is_root = example.skeleton.parent == 0
    is_root[0] = False
    is_turned = is_root | (codec.frame == "scene")
    x, y = x0[is_turned, :2].T
    x0[is_turned, :2] = np.column_stack([-y, x])
    cos, sin = x0[is_root, 3:5].T
    is_angle = codec.yaw == "angle"
    x0[is_root, 3:5] = np.column_stack([cos, np.mod(sin + 3, 4) - 2] if is_angle else [-sin, cos])
    x0[0, [5, 6]] = x0[0, [6, 5]]
    return Example(example.skeleton, example.wish, x0)


def random_symmetry(
    example: Example, rng: np.random.Generator, codec: CodecCfg = DEFAULT_CODEC
) -> Example:
    """One of the eight symmetries of the square."""
    turns, is_mirrored = divmod(int(rng.integers(8)), 2)
    for _ in range(turns):
        example = quarter_turned(example, codec)
    return mirrored(example) if is_mirrored else example
