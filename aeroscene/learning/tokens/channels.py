"""Geometry of a scene as channels of tokens, each in the frame of its parent.

| channels | name | unit |
|---|---|---|
| 0, 1 | place along the parent's axes over the free play there: +-1 touches its border | - |
| 2 | height of the underside above the parent's, over the parent's height (below a site: m) | - |
| 3, 4 | cosine and sine of the yaw relative to the parent; of four times the yaw of a site | - |
| 5, 6, 7 | log of the extents, or of their ratio to the parent's, whichever varies less | - |
| 8 to 14 | `OPENINGS`, m; offsets over half the length of the wall | m |

Where the paper diffuses absolute (p, q, s), a wardrobe against the wall of a room is at +-1 in
every room here, whatever the room's place and size: in a prototype the parent's frame took wrong
supports from 74% to 7% at less training. `aeroscene.learning.tokens.codec` has other choices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.learning.tokens.codec import DEFAULT_CODEC, CodecCfg, quarter_turns
from aeroscene.learning.tokens.kinds import OPENINGS, Vocabulary
from aeroscene.learning.tokens.placed import site_yaw
from aeroscene.learning.tokens.skeleton import Skeleton, token_order
from aeroscene.scene import Scene

N_CHANNELS = 8 + len(OPENINGS)
PLACE, HEIGHT, HEADING, SIZE, OPENING = (
    slice(0, 2),
    slice(2, 3),
    slice(3, 5),
    slice(5, 8),
    slice(8, N_CHANNELS),
)
MIRRORED = (1, 4, 8 + OPENINGS.index("door_offset_m"), 8 + OPENINGS.index("window_offset_m"))
"""Channels that change sign when a scene is mirrored."""
LEAST_PLAY = 0.3
"""Free play counts as at least this share of half the parent's extent, so that what fills its
parent has a place too."""
SITE_HEIGHT_M = 1.0
"""Heights above the ground are in this unit where the parent is the site."""


@dataclass(frozen=True)
class Geometry:
    """World geometry of a skeleton's tokens, the site first: its ground plan and air above."""

    center_enu_m: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    size_m: Float[np.ndarray, "n 3"]
    openings_m: Float[np.ndarray, "n 7"]
    """NaN where an object has no such opening."""


def geometry_of(scene: Scene) -> Geometry:
    """World geometry of a scene in the order of its skeleton."""
    order = token_order(scene)
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    yaw = site_yaw(scene)
    plan = (high - low) / (site_growth(yaw), site_growth(yaw), 1.0)
    boxes = [obj.bbox for obj in order]
    openings = [[obj.attributes.get(name, np.nan) for name in OPENINGS] for obj in order]
    return Geometry(
        np.array([(low + high) / 2, *(box.p for box in boxes)]),
        np.array([yaw, *(box.yaw_rad for box in boxes)]),
        np.array([plan, *(box.s for box in boxes)]),
        np.array([[np.nan] * len(OPENINGS), *openings], dtype=float),
    )


def site_growth(yaw_rad: float) -> float:
    """Width of the flight volume, which is never turned, over that of the ground plan in it."""
    return abs(math.cos(yaw_rad)) + abs(math.sin(yaw_rad))


def reach_along_parent(
    size_m: Float[np.ndarray, "n 3"], cos: Float[np.ndarray, " n"], sin: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 2"]:
    """Half the extents of turned boxes along the axes that they are turned against."""
    a, b = size_m[:, 0], size_m[:, 1]
    cos, sin = np.abs(cos), np.abs(sin)
    return np.stack([cos * a + sin * b, sin * a + cos * b], axis=1) / 2


def play_m(
    parent_size_m: Float[np.ndarray, "n 3"], reach_m: Float[np.ndarray, "n 2"]
) -> Float[np.ndarray, "n 2"]:
    """How far a child may move from the middle of its parent, along the parent's axes."""
    half = parent_size_m[:, :2] / 2
    return np.maximum(half - reach_m, LEAST_PLAY * half)


def channels_of(
    skeleton: Skeleton, geometry: Geometry, codec: CodecCfg = DEFAULT_CODEC
) -> tuple[Float[np.ndarray, "n channels"], Float[np.ndarray, "n 3"]]:
    """Channels before standardisation, NaN where a token has none, and relative log sizes.

    Sizes are logarithms whatever the codec, until it is known which are relative.
    """
    g, parent = geometry, skeleton.parent
    relative = g.yaw_rad - g.yaw_rad[parent]
    cos, sin = np.cos(relative), np.sin(relative)
    reach = reach_along_parent(g.size_m, cos, sin)
    parent_size = g.size_m[parent]
    frame = np.zeros_like(parent) if codec.frame == "scene" else parent
    offset = _turned(g.center_enu_m[:, :2] - g.center_enu_m[frame, :2], -g.yaw_rad[frame])
    underside = g.center_enu_m[:, 2] - g.size_m[:, 2] / 2
    unit = np.where(parent == 0, SITE_HEIGHT_M, parent_size[:, 2])
    height = (underside - underside[parent]) / unit
    along = np.concatenate([2 * reach_along_parent(parent_size, cos, -sin), parent_size[:, 2:]], 1)
    openings = g.openings_m.copy()
    for name in ("door_offset_m", "window_offset_m"):
        openings[:, OPENINGS.index(name)] /= g.size_m[:, 1] / 2
    is_over_play = codec.frame == "play"
    place = offset / (play_m(parent_size, reach) if is_over_play else g.size_m[frame, :2] / 2)
    if codec.yaw == "angle":
        cos, sin = np.zeros_like(relative), quarter_turns(relative)
    log_size = np.log(g.size_m)
    channels = np.column_stack([place, height, cos, sin, log_size, openings])
    channels[0, :3] = 0.0
    channels[0, HEADING] = np.cos(4 * g.yaw_rad[0]), np.sin(4 * g.yaw_rad[0])
    return channels, log_size - np.log(along)


def _turned(offset: Float[np.ndarray, "n 2"], yaw: Float[np.ndarray, " n"]) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack(
        [c * offset[:, 0] - s * offset[:, 1], s * offset[:, 0] + c * offset[:, 1]]
    )


def attachment_heights(
    skeleton: Skeleton, vocabulary: Vocabulary
) -> tuple[Bool[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Which tokens stand on their parent's upper face, and the lift of the others, m.

    A lift of NaN means that the height is a channel.
    """
    kinds = [vocabulary.kinds[k] for k in skeleton.kind_id.tolist()]
    lift: list[float] = []
    for kind, parent in zip(kinds, skeleton.parent.tolist(), strict=True):
        if kind.attachment == "lift" and not kind.is_site:
            height = vocabulary.lift_m(kind.category, kinds[parent].category)
            lift.append(0.0 if np.isnan(height) else height)
        else:
            lift.append(np.nan)
    lift[0] = 0.0
    return np.array([kind.attachment == "top" for kind in kinds]), np.array(lift)
