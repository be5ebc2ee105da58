"""Scenes that hypothesis draws: any that the schema allows, down to the last bit."""

from __future__ import annotations

import math
from dataclasses import replace

from hypothesis import strategies as st

from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneObject

finite = st.floats(-500, 500)
lengths = st.one_of(finite, finite.map(lambda x: round(x, 4)), st.just(-0.0))
vectors = st.tuples(lengths, lengths, lengths)
sizes = st.one_of(
    st.floats(0.001, 900), st.floats(0.001, 900).map(lambda x: max(0.001, round(x, 4)))
)
_shown = st.characters(exclude_categories=("C", "Z"))
words = st.text(_shown, max_size=6)
values = st.one_of(
    words,
    st.booleans(),
    st.integers(-(10**9), 10**9),
    st.floats(-1e9, 1e9),
)
attributes = st.dictionaries(words, values, max_size=3)
names = st.text(_shown, min_size=1, max_size=8)


@st.composite
def quaternions(draw):
    angle, x, y = draw(st.floats(-4, 4)), draw(st.floats(-1, 1)), draw(st.floats(-1, 1))
    if draw(st.booleans()):
        return (round(math.cos(angle / 2), 9), 0.0, -0.0, round(math.sin(angle / 2), 9))
    norm = math.hypot(x, y, 1.0)
    s = math.sin(angle / 2) / norm
    return (math.cos(angle / 2), s * x, s * y, s)


@st.composite
def objects(draw, object_id, scene_id, earlier):
    return SceneObject(
        id=object_id,
        scene_id=scene_id,
        parent_id=draw(st.sampled_from([None, *earlier])),
        category_id=draw(st.integers(1, 70)),
        bbox=OrientedBox(
            draw(vectors), draw(quaternions()), (draw(sizes), draw(sizes), draw(sizes))
        ),
        domain=draw(st.sampled_from(["indoor", "outdoor"])),
        attributes=draw(attributes),
    )


def regular(sides, radius, phase):
    """Corners of a regular polygon about the origin."""
    angles = [phase + 2 * math.pi * i / sides for i in range(sides)]
    return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]


@st.composite
def areas(draw, area_id, bearers):
    sides = draw(st.sampled_from([3, 4, 5, 6, 12]))
    x, y, z = draw(vectors)
    outer = draw(st.floats(0.5, 5))
    digits = draw(st.sampled_from([4, 17]))
    corners = regular(sides, outer, draw(st.floats(-3, 3)))
    polygon = tuple((round(x + u, digits), round(y + v, digits), z) for u, v in corners)
    return InteractionArea(
        id=area_id,
        kind=draw(st.sampled_from(["landing", "perching"])),
        object_id=draw(st.sampled_from([None, *bearers])),
        polygon=polygon,
        centroid=(x, y, z),
        radius=outer * math.cos(math.pi / sides) * draw(st.floats(0.5, 1)),
        drone_class=draw(st.sampled_from(["small", "medium", "large"])),
        slope_rad=draw(st.floats(0, 1.5)),
        clearance_m=draw(st.floats(0.1, 1e3)),
        surface=draw(words),
    )


@st.composite
def scenes(draw):
    scene_id = draw(names)
    ids = draw(st.lists(st.integers(0, 2**31 - 1), unique=True, max_size=5))
    found = [draw(objects(object_id, scene_id, ids[:place])) for place, object_id in enumerate(ids)]
    area_ids = draw(st.lists(st.integers(0, 500), unique=True, max_size=3))
    return Scene(
        scene_id=scene_id,
        domain=draw(st.sampled_from(["indoor", "outdoor", "mixed"])),
        seed=draw(st.integers(0, 2**63 - 1)),
        extent_min_enu_m=(draw(st.floats(-500, -1)), -500.0, draw(st.floats(-500, -1))),
        extent_max_enu_m=(draw(st.floats(0, 500)), 499.9, draw(st.floats(0, 500))),
        start_position_enu_m=(-0.0, draw(st.floats(-500, 499)), draw(st.floats(-1, 0))),
        start_yaw_rad=draw(st.floats(-4, 4)),
        latitude_deg=draw(st.floats(-90, 90)),
        longitude_deg=draw(st.floats(-180, 180)),
        altitude_m=draw(lengths),
        objects=tuple(found),
        interaction_areas=tuple(draw(areas(area_id, ids)) for area_id in area_ids),
        theme=draw(st.sampled_from(["", "park", "\N{SNOWMAN}"])),
    )


def renamed(scene, scene_id):
    """The same scene under another name."""
    members = tuple(replace(obj, scene_id=scene_id) for obj in scene.objects)
    return replace(scene, scene_id=scene_id, objects=members)
