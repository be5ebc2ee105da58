"""The coarse part of a scene that is to be completed, as the beginning of a program."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from aeroscene.learning.generation.request import RequestError
from aeroscene.learning.program import Program, ProgramError, encode
from aeroscene.learning.program.decoding.decode import DecodedProgram
from aeroscene.learning.program.references import with_references
from aeroscene.learning.program.statistics import ProgramExample, to_example
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.learning.writer.growth import Growth, coarse_growth
from aeroscene.learning.writer.language import Language
from aeroscene.partition import PartitionError
from aeroscene.scene import Scene, SceneObject


@dataclass(frozen=True, eq=False)
class GivenPart:
    """Coarse objects that stay, as tokens.

    Kinds that the model never saw are drawn on as the nearest that it knows, and built as they are.
    """

    kept: Scene
    program: Program
    """As the objects are."""
    object_ids: tuple[tuple[int, ...], ...]
    """Objects of each token."""
    example: ProgramExample
    """As the model sees it."""

    @staticmethod
    def of(kept: Scene, language: Language) -> GivenPart:
        """The part of a scene without fine objects.

        Raises:
            RequestError: If it has objects of categories that the model never saw, or no program.
        """
        try:
            encoded = encode(kept)
            example = to_example(encoded, language.vocabulary, language.statistics)
        except KeyError as error:
            strange = str(error.args[0]).split(" ")[-1]
            known = sorted({kind.category for kind in language.vocabulary.kinds if kind.category})
            raise RequestError(
                f"scene {kept.scene_id!r} has an object of category {strange!r}, which the "
                f"model never saw, valid: {', '.join(known)}"
            ) from None
        except (PartitionError, ProgramError) as error:
            raise RequestError(
                f"scene {kept.scene_id!r} cannot be completed ({error}), valid: covers, rooms and "
                "walls that do not overlap"
            ) from None
        program = with_references(encoded, language.statistics.references)
        return GivenPart(kept, program, encoded.object_ids, example)

    @property
    def n_tokens(self) -> int:
        """Tokens that are given."""
        return self.program.n_coarse

    def growth(self, language: Language, wish: Wish) -> Growth:
        """The given tokens, for the writer to furnish."""
        return coarse_growth(language.syntax, self.program, wish)

    def imposed_on(self, program: Program) -> Program:
        """A program whose first tokens are the given ones, as they are."""
        own, n = self.program, self.n_tokens
        arrays = ("parent", "member", "host", "channels", "references")
        return replace(
            program,
            kinds=own.kinds[:n] + program.kinds[n:],
            shapes=own.shapes[:n] + program.shapes[n:],
            **{
                name: np.concatenate([getattr(own, name)[:n], getattr(program, name)[n:]])
                for name in arrays
            },
        )

    def restored_in(self, decoded: DecodedProgram) -> Scene:
        """The decoded scene with the given objects themselves in place of their copies."""
        scene, kept = decoded.scene, self.kept
        place: dict[int | None, int] = {obj.id: n for n, obj in enumerate(kept.objects)}
        new_id: dict[int | None, int | None] = {None: None}
        for made, own in zip(decoded.object_ids, self.object_ids[: self.n_tokens], strict=False):
            new_id |= {copy: place[obj] for copy, obj in zip(made, own, strict=False)}
        objects: list[SceneObject] = [
            replace(obj, id=place[obj.id], parent_id=place.get(obj.parent_id))
            for obj in kept.objects
        ]
        fine = [obj for obj in scene.objects if not obj.is_coarse]
        new_id |= {obj.id: len(objects) + number for number, obj in enumerate(fine)}
        for obj in fine:
            above = obj.parent_id
            while above not in new_id:
                assert above is not None
                above = scene.object_by_id[above].parent_id
            objects.append(replace(obj, id=len(objects), parent_id=new_id[above]))
        has_pad = any(obj.attributes.get("is_start") for obj in kept.objects)
        return replace(
            kept,
            scene_id=scene.scene_id,
            seed=scene.seed,
            objects=tuple(replace(obj, scene_id=scene.scene_id) for obj in objects),
            start_position_enu_m=(kept if has_pad else scene).start_position_enu_m,
            start_yaw_rad=(kept if has_pad else scene).start_yaw_rad,
        )
