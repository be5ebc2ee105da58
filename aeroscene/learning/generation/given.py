"""Objects of a scene that stay as they are, as the given part of a program."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aeroscene.feasibility.region import Region
from aeroscene.learning.program import Program, ProgramError, encode
from aeroscene.learning.program.decoding.draft import Given
from aeroscene.learning.program.decoding.furnish import furnish
from aeroscene.learning.program.references import with_references
from aeroscene.learning.program.statistics import ProgramExample, to_example
from aeroscene.learning.wishes import RequestError, Wish
from aeroscene.learning.writer.furnishing import Furnishing
from aeroscene.learning.writer.language import Language
from aeroscene.partition import PartitionError
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import ROOMS


@dataclass(frozen=True, eq=False)
class GivenPart:
    """Objects that stay, as tokens.

    Kinds that the model never saw are drawn on as the nearest that it knows, and stay as they are.
    """

    kept: Scene
    """All objects that stay, those without a token among them."""
    program: Program
    """As the objects are."""
    object_ids: tuple[tuple[int, ...], ...]
    """Objects of each token."""
    example: ProgramExample
    """As the model sees it."""
    first_id: int = 0
    """Least id of new objects."""

    @staticmethod
    def of(kept: Scene, language: Language, unread: Collection[int] = ()) -> GivenPart:
        """The part that objects are, but for some that no program has.

        Raises:
            RequestError: If it has objects of categories that the model never saw.
        """
        encoded = encode(_without(kept, unread), language.encoding)
        try:
            example = to_example(encoded, language.vocabulary, language.statistics)
        except KeyError as error:
            strange = str(error.args[0]).split(" ")[-1]
            known = sorted({kind.category for kind in language.vocabulary.kinds if kind.category})
            raise RequestError(
                f"scene {kept.scene_id!r} has an object of category {strange!r}, which the "
                f"model never saw; valid: {', '.join(known)}"
            ) from None
        program = with_references(encoded, language.statistics.references)
        return GivenPart(kept, program, encoded.object_ids, example)

    def furnishing(
        self, language: Language, wish: Wish, region: Region | None = None
    ) -> Furnishing:
        """The given tokens, for the writer to furnish: all, or where they reach into a region."""
        syntax = language.syntax
        if region is None:
            return Furnishing(syntax, self.program, wish)
        objects = self.kept.object_by_id
        is_open = [
            token
            for token, ids in enumerate(self.object_ids[: self.program.n_coarse])
            if not token or any(_bears_in(region, objects[each]) for each in ids)
        ]
        return Furnishing(syntax, self.program, wish, is_open, has_start=True)


@dataclass(frozen=True, eq=False)
class PlacedPart:
    """A given part, and where in a program its tokens are."""

    part: GivenPart
    place_of: Mapping[int, int]
    """For each of the part's tokens that are in the program its place there."""

    @property
    def own(self) -> list[int]:
        """Tokens of the part that are in the program."""
        return list(self.place_of)

    @property
    def places(self) -> list[int]:
        """Where they are."""
        return list(self.place_of.values())

    def imposed_on(self, program: Program) -> Program:
        """A program in which the given tokens are as they are."""
        given, own, places = self.part.program, self.own, self.places
        kinds, shapes = list(program.kinds), list(program.shapes)
        for token, place in self.place_of.items():
            kinds[place], shapes[place] = given.kinds[token], given.shapes[token]
        arrays: dict[str, np.ndarray] = {}
        for name in ("member", "host", "channels", "references"):
            arrays[name] = getattr(program, name).copy()
            arrays[name][places] = getattr(given, name)[own]
        return replace(program, kinds=tuple(kinds), shapes=tuple(shapes), **arrays)

    def furnished(self, program: Program, scene_id: str, seed: int) -> Scene:
        """The objects that stay with what else a program has."""
        part = self.part
        ids = {place: part.object_ids[token] for token, place in self.place_of.items()}
        return furnish(program, Given(part.kept, ids, part.first_id), scene_id, seed)


def unread_in(scene: Scene) -> frozenset[int]:
    """Coarse objects of a scene without which it has a program, and all that they bear.

    Most scenes have one with all of them. In some a few lie across each other by more than a
    partition may have: of such the later ones are left out.
    """
    coarse = [obj for obj in scene.objects if obj.is_coarse]
    kept: set[int] = set()

    def add(objects: Sequence[SceneObject]) -> None:
        """Keep as many more as have a program with those that are kept, by halves."""
        tried = kept | {obj.id for obj in objects}
        if _has_program(_without(scene, [o.id for o in scene.objects if o.id not in tried])):
            kept.update(tried)
        elif len(objects) > 1:
            add(objects[: len(objects) // 2])
            add(objects[len(objects) // 2 :])

    add(coarse)
    lost = [obj.id for obj in coarse if obj.id not in kept]
    left = {obj.id for obj in _without(scene, lost).objects}
    return frozenset(obj.id for obj in scene.objects if obj.id not in left)


def _has_program(scene: Scene) -> bool:
    try:
        encode(scene)
    except (PartitionError, ProgramError):
        return False
    return True


def _without(scene: Scene, ids: Collection[int]) -> Scene:
    """A scene without some objects, and without all that belongs to them."""
    gone = set(ids)
    if not gone:
        return scene
    left: list[SceneObject] = []
    for obj in scene.objects:
        if obj.id in gone or obj.parent_id in gone:
            gone.add(obj.id)
        else:
            left.append(obj)
    return replace(scene, objects=tuple(left), interaction_areas=())


def _bears_in(region: Region, obj: SceneObject) -> bool:
    """Whether what an object bears may lie in a region: above it, of a room within it."""
    base_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
    top_m = base_m + obj.bbox.s[2] if obj.category in ROOMS else np.inf
    is_level = base_m <= region.high_enu_m[2] and top_m >= region.low_enu_m[2]
    return is_level and region.is_over(obj.bbox)
