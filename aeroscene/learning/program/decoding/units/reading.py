"""Units from their tokens: the inverse of `aeroscene.learning.program.encoding.units`.

If the host that was drawn does not exist, the nearest rank counts. If there is no host at all, the
unit is scattered on its bearer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.learning.program.encoding.units import pitch_base_m, underside_m
from aeroscene.learning.program.kinds import AS_LAST_AXES, CATEGORY_IDS, OPENINGS, UnitKind, What
from aeroscene.learning.program.measures import (
    Surroundings,
    in_centimetres,
    own_heading_rad,
    reach_of,
    scales,
    size_and_base,
    up_to_level,
)
from aeroscene.learning.program.program import (
    COS,
    OPENING,
    PITCH,
    RISE,
    SIN,
    SIZE,
    TILT,
    Program,
    Shape,
    U,
    V,
)
from aeroscene.relations import Array, Member, Relation, Residual, Unit, place
from aeroscene.relations.hosts import Standing, level_m
from aeroscene.relations.placement import array_half_m, foot_m
from aeroscene.relations.plane import QUARTER, Half, Rectangle
from aeroscene.relations.relation import ANY_TURN, Kind
from aeroscene.scene import AttributeValue, OrientedBox, Quaternion, Vector3
from aeroscene.scene.box import MIN_SIZE_M
from aeroscene.scene.catalogue import ROOMS, STAIRS

BoxOf = Callable[[int | None], OrientedBox | None]
# Limits of the distance between neighbours of an array.
_MOST_PITCH_M = 30.0
_LEAST_PITCH_M = 0.05
LEAST_RISE_M = 0.15
"""Lowest level above the ground that stairs lead up to."""


def read_unit(
    draft: Draft,
    token: int,
    bearer: int | None,
    last_m: Vector3 | None = None,
    *,
    rounds: bool = False,
) -> Unit:
    """Build the unit of a token, on its bearer.

    Args:
        draft: The program, and the objects so far.
        token: Place of the unit's token.
        bearer: Id of the object that bears it; None for the ground.
        last_m: Extents of the last unit with the same key, which it may copy; None without one.
        rounds: True rounds extents to whole centimetres.
    """
    program, box_of = draft.program, draft.box
    kind = program.unit(token)
    members = [i for i in draft.children[token] if program.kinds[i].node == "member"]
    c = np.nan_to_num(program.channels[token]).tolist()
    relation, host = _related(draft, token, bearer)
    residual_rad = own_heading_rad(*program.channels[token, [COS, SIN]].tolist())
    turn = 0 if relation.quadrant == ANY_TURN else relation.quadrant
    host_box = box_of(host)
    host_rad = 0.0 if host_box is None else host_box.yaw_rad
    yaw_rad = host_rad + (relation.side + turn) * QUARTER + residual_rad
    around = Surroundings(box_of(bearer), up_to_level(draft.standing.category(host), host_box))
    size_m, base_m = size_and_base(
        around,
        [c[RISE], *c[SIZE]],
        program.references[token].tolist(),
        yaw_rad,
        is_on_top=kind.is_on_top,
    )
    if rounds:
        size_m = in_centimetres(size_m, program.references[token, 1:].tolist())
    if last_m is not None:
        as_last = set(AS_LAST_AXES[kind.as_last])
        if relation.kind == Kind.SIDE and kind.category in STAIRS:
            # Stairs are as high as their level asks, even if the other
            # extents copy the last stairs'.
            as_last.discard(2)
        x_m, y_m, z_m = (last_m[i] if i in as_last else size_m[i] for i in range(3))
        size_m = x_m, y_m, z_m
    # A group whose array has only holes would have no members.
    shape = _shape(program, token, relation.kind)
    n_members = len(shape.array().cells(relation.kind)) if kind.is_group else 1
    own_m = base_m - _low_m(around.bearer)
    made = _members(program, token, members, size_m, own_m, n_members, rounds=rounds)
    halves_m = [foot_m(member.category_id, member.size_m) for member in made]
    host_outline = draft.outline(host)
    array = None
    if kind.is_group:
        array = _array(program, token, shape, relation.kind, halves_m, host_outline)
    is_seat = relation.kind == Kind.SEAT
    half_m = halves_m[0] if is_seat else array_half_m(array, halves_m)
    (u0, u1), (v0, v1) = scales(relation, host_outline, reach_of(relation, residual_rad, half_m))
    return Unit(
        parent_id=bearer,
        host_id=host,
        relation=relation,
        members=tuple(made),
        array=array,
        residual=Residual(u0 + u1 * c[U], v0 + v1 * c[V], residual_rad),
    )


def with_own_sizes(program: Program) -> Program:
    """Give sizes to units that copy the last one, in case none comes before them.

    They are those of the first unit with the same key that has its own. A unit that is drawn later
    may be built earlier, because building goes from the ground up.
    """
    channels, references = program.channels.copy(), program.references.copy()
    like: dict[What, int] = {}
    units = [(i, kind) for i, kind in enumerate(program.kinds) if isinstance(kind, UnitKind)]
    for token, kind in units:
        if not kind.as_last:
            like.setdefault(kind.what, token)
    for token, kind in units:
        other = like.get(kind.what)
        for axis in AS_LAST_AXES[kind.as_last] if other is not None else ():
            channels[token, SIZE.start + axis] = program.channels[other, SIZE.start + axis]
            references[token, 1 + axis] = program.references[other, 1 + axis]
    return replace(program, channels=channels, references=references)


def member_boxes(unit: Unit, box_of: BoxOf) -> list[OrientedBox]:
    """Return the boxes of a unit's members, in order."""
    ids = (unit.parent_id, unit.host_id)
    hosts = {each: box for each in ids if each is not None and (box := box_of(each)) is not None}
    # Negative ids cannot meet those of hosts.
    made = [replace(member, id=-1 - index) for index, member in enumerate(unit.members)]
    boxes = place([replace(unit, members=tuple(made))], hosts)
    return [boxes[member.id] for member in made]


def openings_of(program: Program, place: int, box: OrientedBox) -> dict[str, AttributeValue]:
    """Return the openings of a unit's object, limited to the wall that they are in.

    Args:
        program: The program.
        place: Place of the unit's token.
        box: Box of the object.

    Returns:
        Attributes of the object, in m.
    """
    values = dict(zip(OPENINGS, program.channels[place, OPENING].tolist(), strict=True))
    half_m = box.s[1] / 2
    found: dict[str, AttributeValue] = {}
    for name in program.unit(place).openings:
        value = 0.0 if math.isnan(values[name]) else values[name]
        if name.endswith("offset_m"):
            width_m = values[name.replace("offset_m", "m")]
            # The offset leaves half of the opening's width at either end.
            play = max(0.0, 1.0 - (0.0 if math.isnan(width_m) else width_m) / 2 / half_m)
            value = min(max(value, -play), play) * half_m
        else:
            most_m = box.s[2] if "height" in name or "sill" in name else 2 * half_m
            value = min(max(value, 0.0), most_m)
        found[name] = round(value, 4)
    return found


def _related(draft: Draft, token: int, bearer: int | None) -> tuple[Relation, int | None]:
    """Return the relation of a unit and its host.

    The host is the one of the drawn rank, or the last before it. For stairs it is the next host
    that is higher than their bearer, for other units the nearest rank with a suitable host.
    """
    program, standing, box_of = draft.program, draft.standing, draft.box
    kind = program.unit(token)
    relation = kind.to_relation(0)
    hosts = standing.possible_hosts(relation.kind, CATEGORY_IDS[kind.category], bearer)
    if not hosts:
        return Relation(kind=Kind.SCATTER, quadrant=relation.quadrant), bearer
    rank = min(max(int(program.host[token]), 0), len(hosts) - 1)
    if kind.category in STAIRS and relation.kind == Kind.SIDE:
        higher = [i for i, host in enumerate(hosts) if _is_higher(host, bearer, standing, box_of)]
        rank = next((i for i in higher if i >= rank), higher[0] if higher else rank)
    elif len(hosts) > 1:
        rank = program.companions.nearest(kind, rank, list(map(draft.host_key, hosts)))
    return replace(relation, host=rank), hosts[rank]


def _is_higher(host: int | None, bearer: int | None, standing: Standing, box_of: BoxOf) -> bool:
    """True if the level of a host is above the ground that an object stands on."""
    box, ground = box_of(host), box_of(bearer)
    if box is None or ground is None:
        return box is not None
    is_inside = standing.category(bearer) in ROOMS
    ground_m = underside_m(ground) if is_inside else level_m(standing.category(bearer), ground)
    return level_m(standing.category(host), box) > ground_m + LEAST_RISE_M


def _shape(program: Program, token: int, kind: Kind) -> Shape:
    """Return the array of a group, without its holes if they leave nothing."""
    shape = program.shapes[token]
    return shape if shape.array().cells(kind) else shape._replace(holes=())


def _members(
    program: Program,
    token: int,
    places: Sequence[int],
    size_m: Vector3,
    rise_m: float,
    n_members: int,
    *,
    rounds: bool,
) -> list[Member]:
    """Return the members of a unit: all alike, or by their own tokens."""
    plain = Member(
        id=0,
        category_id=CATEGORY_IDS[program.kinds[token].category],
        size_m=size_m,
        is_on_top=False,
        rise_m=rise_m,
        tilt_wxyz=_tilt(program, token),
    )
    if not places:
        return [plain] * n_members
    found: list[Member] = []
    for index in range(n_members):
        c = np.nan_to_num(program.channels[places[min(index, len(places) - 1)]])
        x_m, y_m, z_m = (
            # At most e times as large as the unit: a wild number must not fill the room.
            max(MIN_SIZE_M, extent * math.exp(min(log, 1.0)))
            for extent, log in zip(size_m, c[SIZE].tolist(), strict=True)
        )
        residual = Residual(float(c[U]), float(c[V]), math.atan2(c[SIN], c[COS]))
        own_m = rise_m + float(c[RISE])
        own_size_m = x_m, y_m, z_m
        if rounds:
            own_size_m = in_centimetres(own_size_m, (0, 0, 0))
        found.append(replace(plain, size_m=own_size_m, rise_m=own_m, residual=residual))
    return found


def _array(
    program: Program,
    token: int,
    shape: Shape,
    kind: Kind,
    halves_m: Sequence[Half],
    outline: Rectangle,
) -> Array:
    gaps_m = np.nan_to_num(program.channels[token, PITCH]).tolist()
    extents_m = pitch_base_m(kind, halves_m)
    pitch_m = [
        min(max(gap_m, 0.0) + max(extent_m, _LEAST_PITCH_M), _MOST_PITCH_M) if count > 1 else 0.0
        for gap_m, extent_m, count in zip(gaps_m, extents_m, shape[:2], strict=True)
    ]
    if kind == Kind.SEAT:
        # Chairs at the ends of a side still stand at their table.
        sides_m = reversed(outline.half_m)
        most_m = [
            2 * half_m / (count - 1) if count > 1 else 0.0
            for half_m, count in zip(sides_m, shape[:2], strict=True)
        ]
        pitch_m = [min(pair) for pair in zip(pitch_m, most_m, strict=True)]
    turned = tuple(index for index in shape.turned if index < len(halves_m))
    return shape._replace(turned=turned).array((pitch_m[0], pitch_m[1]))


def _tilt(program: Program, token: int) -> Quaternion | None:
    if not program.unit(token).is_tilted:
        return None
    x, y = np.nan_to_num(program.channels[token, TILT]).tolist()
    w, i, j, k = Rotation.from_rotvec((x, y, 0.0)).as_quat(scalar_first=True).tolist()
    return w, i, j, k


def _low_m(box: OrientedBox | None) -> float:
    return 0.0 if box is None else underside_m(box)
