"""Scenes with faults put in by hand: what a check judges is moved, turned or cut."""

import itertools
import math
from dataclasses import replace

import numpy as np

from aeroscene.relations.plane import footprint, turned_reach_m
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw


def changed(scene, chosen, change):
    """The scene with `change(box)` in the place of the boxes of the objects of these ids."""
    objects = tuple(
        replace(obj, bbox=change(obj.bbox)) if obj.id in chosen else obj for obj in scene.objects
    )
    return replace(scene, objects=objects, interaction_areas=())


def every(scene, *categories):
    return {obj.id for obj in scene.objects if obj.category in categories}


def halves(scenes, *categories):
    """For each scene the ids of every other object of some categories, counted over all scenes."""
    count = itertools.count()
    for scene in scenes:
        found = [obj.id for obj in scene.objects if obj.category in categories]
        yield scene, {number for number in found if next(count) % 2 == 0}


def shifted(forward_m, left_m=0.0, up_m=0.0):
    """A change that moves a box along its own axes."""

    def change(box):
        c, s = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
        shift = (c * forward_m - s * left_m, s * forward_m + c * left_m, up_m)
        return replace(box, p=tuple((np.array(box.p) + shift).tolist()))

    return change


def turned_by(angle_deg):
    def change(box):
        return replace(box, q=quat_from_yaw(box.yaw_rad + math.radians(angle_deg)))

    return change


def scaled(x, y):
    def change(box):
        return replace(box, s=(box.s[0] * x, box.s[1] * y, box.s[2]))

    return change


def without(scene, chosen):
    """The scene without some objects; their children stand on what they stood on."""
    parent = {obj.id: obj.parent_id for obj in scene.objects}

    def kept(number):
        while number in chosen:
            number = parent[number]
        return number

    objects = tuple(
        replace(obj, parent_id=kept(obj.parent_id)) for obj in scene.objects if obj.id not in chosen
    )
    return replace(scene, objects=objects, interaction_areas=())


def strewn(scene, rng):
    """Fine objects at random places within their parents, headed as they were."""
    boxes = {}
    for obj in scene.objects:
        box = boxes[obj.id] = obj.bbox
        if obj.is_coarse or obj.parent_id is None:
            continue
        before = footprint(scene.object_by_id[obj.parent_id].bbox)
        parent = footprint(boxes[obj.parent_id])
        turn_rad = before.place.local(footprint(box).place)[2]
        reach_m = turned_reach_m(footprint(box).half_m, turn_rad)
        play_m = np.maximum(0.0, np.subtract(parent.half_m, reach_m))
        spot = parent.place.moved(*rng.uniform(-play_m, play_m).tolist())
        boxes[obj.id] = OrientedBox((spot.x_m, spot.y_m, box.p[2]), box.q, box.s)
    objects = tuple(replace(obj, bbox=boxes[obj.id]) for obj in scene.objects)
    return replace(scene, objects=objects, interaction_areas=())
