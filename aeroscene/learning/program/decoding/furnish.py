"""Decoding of a program's new objects among objects that stand already, none of which moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aeroscene.learning.program.decoding.decode import Builder
from aeroscene.learning.program.decoding.draft import Given
from aeroscene.learning.program.flight import start_pad, top_of, yaw_inwards
from aeroscene.learning.program.program import Program
from aeroscene.scene import Scene


def furnish(program: Program, given: Given, scene_id: str, seed: int) -> Scene:
    """Add the other objects of a program to a given scene, without areas.

    Given objects keep their ids and stay as they are. New objects come after them, with greater
    ids.

    Args:
        program: Program of given and new objects, whatever its numbers.
        given: The objects that stand, and their tokens.
        scene_id: Name of the scene.
        seed: Seed that the scene states.
    """
    builder = Builder(program)
    builder.draft.begin_with(given)
    builder.build()
    kept, made = given.scene, builder.draft.objects
    # A draft numbers objects by their place; the scene keeps the given ids.
    ids = [obj.id for obj in kept.objects]
    first_id = max(given.first_id, 1 + max(ids, default=-1))
    ids += range(first_id, first_id + len(made) - len(ids))
    new = [
        replace(
            obj, id=ids[obj.id], parent_id=None if obj.parent_id is None else ids[obj.parent_id]
        )
        for obj in made[len(kept.objects) :]
    ]
    objects = tuple(replace(obj, scene_id=scene_id) for obj in (*kept.objects, *new))
    scene = replace(kept, scene_id=scene_id, seed=seed, objects=objects, interaction_areas=())
    # A new start pad moves the start of the flight; otherwise it stays.
    pad = start_pad(new)
    if pad is None:
        return scene
    start = np.clip(top_of(pad), kept.extent_min_enu_m, kept.extent_max_enu_m).tolist()
    place = (start[0], start[1], start[2])
    return replace(scene, start_position_enu_m=place, start_yaw_rad=yaw_inwards(start))
