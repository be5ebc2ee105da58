"""Objects of the world by name, with their poses and their numbers for segmentation."""

from __future__ import annotations

import re

from autonomy.types import Quaternion, Vector3, quat_about_up
from flightsim.world import (
    FIRST_MATE_ID,
    FIRST_MOVER_ID,
    GROUND_ID,
    NEIGHBOUR_ID,
    VEHICLE_ID,
)
from scenarios.airsim.craft import Craft, Names
from scenarios.airsim.methods import RpcError

_MOST_PATTERN = 200
_MOST_REPEATS = 3
MOST_SEGMENT = (1 << 24) - 1
"""Greatest number for segmentation: each has a colour of its own."""


class Objects:
    """Objects of the scene, movers and vehicles, by the names that clients use.

    Attributes:
        segment_ids: Number for segmentation of each object id.
    """

    def __init__(self, crafts: list[Craft], names: Names) -> None:
        """Name everything.

        Args:
            crafts: The vehicles.
            names: Names of what is in the world.
        """
        self._crafts, self._names = crafts, names
        world = crafts[0].vehicle.plant.world
        self._plant = crafts[0].vehicle.plant
        ids = [GROUND_ID, NEIGHBOUR_ID, *names.objects]
        ids += [FIRST_MOVER_ID - i for i in range(len(world.obstacles))]
        self._ids = {names.of(each): each for each in ids}
        self._vehicles = {craft.name: craft for craft in crafts}
        self._boxes = {each.id: each.bbox for each in world.scene.objects}
        self.segment_ids = {each: number for number, each in enumerate(self._ids.values(), 1)}
        first = len(self.segment_ids) + 1
        for k, craft in enumerate(crafts):
            self._ids[craft.name] = VEHICLE_ID if k == 0 else FIRST_MATE_ID - k
            self.segment_ids[FIRST_MATE_ID - k] = first + k

    def named(self, pattern: str) -> list[str]:
        """Names that a pattern matches as a whole.

        Raises:
            RpcError: If it is no pattern.
        """
        if len(pattern) > _MOST_PATTERN or _may_hang(pattern):
            raise RpcError(
                f"pattern {pattern[:80]!r} is too long, or repeats groups or too often; valid: up "
                f"to {_MOST_PATTERN} characters and {_MOST_REPEATS} repetitions such as 'tree.*'"
            )
        try:
            regex = re.compile(pattern, re.IGNORECASE)
        except (re.error, OverflowError, RecursionError) as error:
            raise RpcError(f"{pattern[:80]!r} is no regular expression: {error}") from None
        return [name for name in self._ids if regex.fullmatch(name)]

    def pose(self, name: str) -> tuple[Vector3, Quaternion] | None:
        """Centre and attitude of a thing; None if there is none of this name."""
        if name in self._vehicles:
            truth = self._vehicles[name].vehicle.plant.truth
            return truth.position_enu_m, truth.quat_wxyz
        object_id = self._ids.get(name)
        if object_id is None:
            return None
        if object_id in self._boxes:
            box = self._boxes[object_id]
            return box.p, box.q
        if object_id <= FIRST_MOVER_ID:
            states, i = self._plant.obstacles_true, FIRST_MOVER_ID - object_id
            x, y, z = states.position_enu_m[i].tolist()
            return (x, y, z), quat_about_up(float(states.yaw_rad[i]))
        return (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)

    def segment_of(self, name: str) -> int:
        """Number of a thing for segmentation; -1 if there is none of this name."""
        object_id = self._ids.get(name)
        if name in self._vehicles:
            object_id = FIRST_MATE_ID - self._crafts.index(self._vehicles[name])
        return -1 if object_id is None else self.segment_ids[object_id]

    def set_segment(self, name: str, number: int, *, is_pattern: bool) -> bool:
        """Give objects a number for segmentation; whether there are any.

        Raises:
            RpcError: If the number or the pattern is not valid.
        """
        if not 0 <= number <= MOST_SEGMENT:
            raise RpcError(f"object_id {number} is not valid; valid: 0 to {MOST_SEGMENT}")
        names = self.named(name) if is_pattern else [each for each in self._ids if each == name]
        for each in names:
            object_id = self._ids[each]
            if each in self._vehicles:
                object_id = FIRST_MATE_ID - self._crafts.index(self._vehicles[each])
            self.segment_ids[object_id] = number
        return bool(names)


def _may_hang(pattern: str) -> bool:
    """Return True if a pattern may take long to fail: it repeats a group, or repeats often."""
    plain = re.sub(r"\\.|\[[^\]]*\]", "x", pattern)
    repeats = len(re.findall(r"[*+{]", plain))
    return repeats > _MOST_REPEATS or re.search(r"\)[*+?{]", plain) is not None
