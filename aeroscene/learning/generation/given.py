"""Objects of a scene that stay as they are, as the given part of a program.

Completing and redoing scenes needs the model to draw beside objects that it did not draw. These
objects are encoded as tokens of a program, so that the writer can go on from them and the denoiser
sees them. Afterwards the exact program of the objects replaces the model's view of it, because that
view rounds kinds and ranges to what training has seen.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

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

    Kinds that the model never saw are shown to it as the nearest kind that it knows. The objects
    themselves stay as they are.
    """

    kept: Scene
    """All objects that stay, also those without a token."""
    program: Program
    """Program of the objects exactly as they are."""
    object_ids: tuple[tuple[int, ...], ...]
    """Ids of the objects of each token."""
    example: ProgramExample
    """The program as the model sees it."""
    first_id: int = 0
    """Least id of new objects."""

    @staticmethod
    def of(kept: Scene, language: Language, unread: Collection[int] = ()) -> GivenPart:
        """Encode objects that stay.

        Args:
            kept: Scene of the objects.
            language: Vocabulary and statistics of the model.
            unread: Ids of objects that stay without a token, see `unread_in`.

        Raises:
            RequestError: If an object has a category that the model never saw.
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
        # The exact program counts from the same references as the model's, so
        # channels can be exchanged.
        program = with_references(encoded, language.statistics.references)
        return GivenPart(kept, program, encoded.object_ids, example)

    def furnishing(
        self, language: Language, wish: Wish, region: Region | None = None
    ) -> Furnishing:
        """Let the writer furnish the given tokens.

        Args:
            language: Vocabulary and statistics of the model.
            wish: Contents of the whole scene.
            region: Opens only those tokens that can bear something in it; None opens all.
        """
        syntax = language.syntax
        if region is None:
            return Furnishing(syntax, self.program, wish)
        objects = self.kept.object_by_id
        is_open = [
            token
            for token, ids in enumerate(self.object_ids[: self.program.n_coarse])
            # Token 0 is the site, which may always get children.
            if not token or any(_bears_in(region, objects[each]) for each in ids)
        ]
        return Furnishing(syntax, self.program, wish, is_open, has_start=True)


@dataclass(frozen=True, eq=False)
class PlacedPart:
    """A given part, and the places of its tokens in a program."""

    part: GivenPart
    place_of: Mapping[int, int]
    """Place in the program of each token of the part that is in it."""

    @property
    def own(self) -> list[int]:
        """Tokens of the part that are in the program."""
        return list(self.place_of)

    @property
    def places(self) -> list[int]:
        """Places of these tokens in the program, in the same order."""
        return list(self.place_of.values())

    def imposed_on(self, program: Program) -> Program:
        """Return the program with the given tokens exactly as given."""
        given, own, places = self.part.program, self.own, self.places
        kinds, shapes = list(program.kinds), list(program.shapes)
        for token, place in self.place_of.items():
            kinds[place], shapes[place] = given.kinds[token], given.shapes[token]
        arrays: dict[str, Any] = {}
        for name in ("member", "host", "channels", "references"):
            arrays[name] = getattr(program, name).copy()
            arrays[name][places] = getattr(given, name)[own]
        return replace(program, kinds=tuple(kinds), shapes=tuple(shapes), **arrays)

    def furnished(self, program: Program, scene_id: str, seed: int) -> Scene:
        """Return the objects that stay, together with the other objects of a program."""
        part = self.part
        ids = {place: part.object_ids[token] for token, place in self.place_of.items()}
        return furnish(program, Given(part.kept, ids, part.first_id), scene_id, seed)


def unread_in(scene: Scene) -> frozenset[int]:
    """Return the objects that keep a scene from having a program, with all that they bear.

    Most scenes have a program with all of their objects. In some, a few coarse objects overlap each
    other by more than a partition may have; the later ones of these are left out.

    Args:
        scene: Any scene.

    Returns:
        Ids of the objects to leave out; empty for most scenes.
    """
    coarse = [obj for obj in scene.objects if obj.is_coarse]
    kept: set[int] = set()

    def add(objects: Sequence[SceneObject]) -> None:
        """Keep as many more as have a program with those that are kept, by halves."""
        tried = kept | {obj.id for obj in objects}
        # Halving needs few encodings if few objects are at fault.
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
    """Return a scene without some objects and all of their descendants, and without areas."""
    gone = set(ids)
    if not gone:
        return scene
    left: list[SceneObject] = []
    for obj in scene.objects:
        # Parents come before their children in a scene, so one pass finds all descendants.
        if obj.id in gone or obj.parent_id in gone:
            gone.add(obj.id)
        else:
            left.append(obj)
    return replace(scene, objects=tuple(left), interaction_areas=())


def _bears_in(region: Region, obj: SceneObject) -> bool:
    """True if the objects on this one may lie in a region: above it, or inside of a room."""
    base_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
    top_m = base_m + obj.bbox.s[2] if obj.category in ROOMS else np.inf
    # Furniture and ground have no upper limit for what they bear.
    is_level = base_m <= region.high_enu_m[2] and top_m >= region.low_enu_m[2]
    return is_level and region.is_over(obj.bbox)
