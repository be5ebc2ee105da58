"""Scenes as training examples. Worker processes run this, so nothing here needs PyTorch."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from aeroscene.learning.program import (
    WHOLE,
    EncodedProgram,
    EncodingCfg,
    ProgramError,
    encode,
)
from aeroscene.learning.program.statistics import ProgramExample, to_example
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.growth import replay
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.lesson import Lesson, lesson_of
from aeroscene.partition import PartitionError
from aeroscene.scene import Scene


class UnencodableError(ValueError):
    """A scene cannot be learned from with the known kinds; one line has the reason."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A scene as an example for the denoiser and for the writer, with its contents."""

    example: ProgramExample
    lesson: Lesson
    wish: Wish


@dataclass(frozen=True, slots=True, eq=False)
class ProgramEncoder:
    """Turns scenes into examples of one language, in any process."""

    language: Language

    def __call__(self, scene: Scene, wish: Wish) -> Written:
        """Encode a scene as if it had been drawn for a wish.

        Raises:
            UnencodableError: If it has no program, or an object has an unknown category.
        """
        encoded = encoded_program(scene, self.language.encoding)
        return written(encoded, wish, self.language)


def encoded_program(scene: Scene, cfg: EncodingCfg = WHOLE) -> EncodedProgram:
    """Return the program of a scene.

    Raises:
        UnencodableError: If it has none.
    """
    try:
        return encode(scene, cfg)
    except (PartitionError, ProgramError) as error:
        raise UnencodableError(f"scene {scene.scene_id!r} has no program: {error}") from None


def written(encoded: EncodedProgram, wish: Wish, language: Language) -> Written:
    """Turn a program into examples.

    Raises:
        UnencodableError: If an object has an unknown category.
    """
    try:
        example = to_example(encoded, language.vocabulary, language.statistics)
    except KeyError as error:
        raise UnencodableError(f"kind {error.args[0]} is unknown") from None
    # The lesson replays the growth that a draw would go through, with the right choices.
    growth, said = replay(language.syntax, encoded.program, wish)
    return Written(example, lesson_of(growth, said, wish), wish)


def encodable(
    scenes: Iterable[Scene], cfg: EncodingCfg = WHOLE
) -> tuple[list[EncodedProgram], list[Wish]]:
    """Return the programs of those scenes that have one, and their contents."""
    found: list[EncodedProgram] = []
    wishes: list[Wish] = []
    for scene in scenes:
        try:
            found.append(encoded_program(scene, cfg))
        # One scene without a program must not stop a corpus of thousands.
        except UnencodableError:
            continue
        wishes.append(Wish.from_scene(scene))
    return found, wishes
