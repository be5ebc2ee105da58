"""Scenes as what is learned from them. Worker processes do this, so nothing here needs PyTorch."""

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
    """A scene that cannot be learned from by what is known; one line that says why."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A scene as the denoiser and as the writer learn it, and what it has."""

    example: ProgramExample
    lesson: Lesson
    wish: Wish


@dataclass(frozen=True, slots=True, eq=False)
class ProgramEncoder:
    """From scenes to examples of one language, in whichever process."""

    language: Language

    def __call__(self, scene: Scene, wish: Wish) -> Written:
        """The scene as its program, as it would come of a wish.

        Raises:
            UnencodableError: If it has none, or an object is of a category that is unknown.
        """
        encoded = encoded_program(scene, self.language.encoding)
        return written(encoded, wish, self.language)


def encoded_program(scene: Scene, cfg: EncodingCfg = WHOLE) -> EncodedProgram:
    """The program of a scene.

    Raises:
        UnencodableError: If it has none.
    """
    try:
        return encode(scene, cfg)
    except (PartitionError, ProgramError) as error:
        raise UnencodableError(f"scene {scene.scene_id!r} has no program: {error}") from None


def written(encoded: EncodedProgram, wish: Wish, language: Language) -> Written:
    """A program as examples.

    Raises:
        UnencodableError: If an object is of a category that is unknown.
    """
    try:
        example = to_example(encoded, language.vocabulary, language.statistics)
    except KeyError as error:
        raise UnencodableError(f"kind {error.args[0]} is unknown") from None
    growth, said = replay(language.syntax, encoded.program, wish)
    return Written(example, lesson_of(growth, said, wish), wish)


def encodable(
    scenes: Iterable[Scene], cfg: EncodingCfg = WHOLE
) -> tuple[list[EncodedProgram], list[Wish]]:
    """Those scenes that have a program, and what they have."""
    found: list[EncodedProgram] = []
    wishes: list[Wish] = []
    for scene in scenes:
        try:
            found.append(encoded_program(scene, cfg))
        except UnencodableError:
            continue
        wishes.append(Wish.of(scene))
    return found, wishes
