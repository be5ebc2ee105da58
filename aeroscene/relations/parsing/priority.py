"""Choice of one relation among those that hold for an object, by a fixed priority.

Several relations usually hold: a bench at a wall is also scattered in its room. The relation that
pins most axes says most, so it is chosen. A fixed order decides ties, because the model has to
learn one answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from aeroscene.relations.hosts import Standing, is_furniture, level_m
from aeroscene.relations.parsing import fits
from aeroscene.relations.placement import foot_m
from aeroscene.relations.plane import WORLD, Rectangle, footprint
from aeroscene.relations.relation import HEADED, Kind, Relation
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import ROOMS, ROUND, SEATS, SIGNALS, STAIRS, VEHICLES

STEP_M = 0.25
"""Greatest step between the top of stairs and the level that they lead up to."""
Choice = tuple[Relation, int | None]
"""A relation, and the id of its host."""


class Ground:
    """Everything that relations are read from: outlines, categories, and the objects so far."""

    def __init__(self, scene: Scene, standing: Standing) -> None:
        """Compute the outline of every box once."""
        self.scene = scene
        self.standing = standing
        self._outlines = {obj.id: footprint(obj.bbox) for obj in scene.objects}

    def outline(self, object_id: int | None) -> Rectangle:
        """Return an object's outline as seen from above; None stands for the ground."""
        return WORLD if object_id is None else self._outlines[object_id]

    def foot(self, obj: SceneObject) -> Rectangle:
        """Return the footprint from which an object's place is read, see `foot_m`."""
        return Rectangle(self.outline(obj.id).place, foot_m(obj.category_id, obj.bbox.s))

    def is_top(self, object_id: int | None) -> bool:
        """True if an object is furniture, which bears other objects on top."""
        if object_id is None:
            return False
        return is_furniture(self.scene.object_by_id[object_id].category_id)

    def is_step(self, obj: SceneObject, object_id: int | None) -> bool:
        """True if the top of an object is as high as another object's level, within `STEP_M`."""
        if object_id is None:
            return False
        other = self.scene.object_by_id[object_id]
        top_m = obj.bbox.p[2] + obj.bbox.s[2] / 2
        return abs(top_m - level_m(other.category, other.bbox)) <= STEP_M

    def category(self, object_id: int | None) -> str:
        """Return the category of an object; empty for the ground."""
        return "" if object_id is None else self.scene.object_by_id[object_id].category


def best_relation(ground: Ground, obj: SceneObject, outline: Rectangle) -> Choice:
    """Return the relation of an object, or of a group of its kind.

    It is the relation that pins most axes. Among equals the first of `Kind` counts, and its
    likeliest host. Traffic lights and stairs are beside their roads and levels before all else.

    Args:
        ground: Scene and objects so far.
        obj: The object, or one of the group.
        outline: Its outline, or the group's.
    """
    choices = list(_choices(ground, obj, outline))
    if obj.category in SIGNALS | STAIRS:
        # A light that no road explains keeps its other relations.
        choices = [choice for choice in choices if choice[0].kind == Kind.SIDE] or choices
    return max(choices, key=_preference)


def _preference(choice: Choice) -> tuple[int, int, bool, int]:
    relation, _ = choice
    is_u, is_v, is_yaw = relation.pinned
    # Pinned axes first; a smaller kind and rank is better, so both are negated.
    return is_u + is_v, -relation.kind, is_yaw, -relation.host


def _choices(ground: Ground, obj: SceneObject, outline: Rectangle) -> Iterator[Choice]:
    """Yield the relations that hold."""
    parent_id = obj.parent_id
    parent, is_top = ground.outline(parent_id), ground.is_top(parent_id)
    # This one always holds, so there is always a choice.
    yield fits.scatter(parent, outline, Kind.ON if is_top else Kind.SCATTER), parent_id
    if parent_id is not None:
        is_walled = ground.category(parent_id) in ROOMS
        is_round = obj.category in ROUND
        for relation in fits.inside(
            parent, outline, is_round=is_round, is_top=is_top, is_walled=is_walled
        ):
            yield relation, parent_id
    for kind in _kinds(obj, is_top=is_top):
        hosts = ground.standing.possible_hosts(kind, obj.category_id, parent_id)
        for rank, host_id in enumerate(hosts):
            if obj.category in STAIRS and not ground.is_step(obj, host_id):
                continue
            for relation in _fits(ground, kind, host_id, obj, outline):
                yield replace(relation, host=rank), host_id


def _kinds(obj: SceneObject, *, is_top: bool) -> list[Kind]:
    """Return the relations that an object may have to hosts other than its parent."""
    if is_top or obj.category in SIGNALS | STAIRS:
        return [Kind.SIDE]
    return [Kind.SIDE, Kind.OVER, Kind.FACING] + [Kind.LANE] * (obj.category in VEHICLES)


def _fits(
    ground: Ground, kind: Kind, host_id: int | None, obj: SceneObject, outline: Rectangle
) -> Iterator[Relation]:
    host = ground.outline(host_id)
    match kind:
        case Kind.LANE:
            return fits.lane(host, outline)
        case Kind.OVER:
            return fits.over(host, outline)
        case Kind.FACING:
            return fits.facing(host, outline)
        case _:
            host_kind = _host_kind(ground, host_id, obj)
            found = fits.beside(host, outline, host_kind, is_round=obj.category in ROUND)
            if obj.category in STAIRS:
                return (relation for relation in found if relation.quadrant == HEADED[Kind.FACING])
            return found


def _host_kind(ground: Ground, host_id: int | None, obj: SceneObject) -> fits.HostKind:
    if obj.category in SIGNALS:
        return "verge"
    if obj.category in STAIRS:
        return "path"
    if ground.is_top(obj.parent_id):
        # A plate may lie off its chair; other small objects belong together if they touch.
        return "object" if ground.category(host_id) in SEATS else "small"
    return "object" if ground.is_top(host_id) else "path"
