"""Collision rate: the share of boxes that run into each other.

The paper's collision rate is the share of ALL pairs of objects with an IoU above 0.01. It shrinks
as the number of objects grows, and it counts objects that belong together: a room's box fills its
building's. Three more figures stand beside it: the share of objects in collision, the share of
scenes with any, and the mean depth. Each is measured among all pairs, among pairs that are not
parent and child, and among strangers, neither of which is the other's ancestor. IoU also misses a
cup in a wall, because the cup is small. Therefore objects that reach more than a centimetre into a
stranger are counted by depth.

Source: AeroScene, "Evaluation Metrics", CR.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.metrics.arrays import SceneArrays, scene_arrays
from aeroscene.scene import Scene
from aeroscene.scene.geometry import penetration_depth
from aeroscene.scene.overlap import near_pairs, pair_iou

MAX_IOU = 0.01
"""The paper's threshold, above which two boxes collide."""
MAX_DEPTH_M = 0.01
"""Depth above which a box reaches into a stranger."""

Among = Literal["all", "not parent and child", "strangers"]
"""Pairs that are counted."""


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Every pair of boxes of a scene that share volume."""

    n_objects: int
    n_pairs: dict[Among, int]
    """Number of pairs of each kind, overlapping or not."""
    first: Int[np.ndarray, " k"]
    """Row of the pair's first object, which is below that of its second."""
    second: Int[np.ndarray, " k"]
    iou: Float[np.ndarray, " k"]
    depth_m: Float[np.ndarray, " k"]
    """Least translation that parts the two, by separating axes."""
    is_among: dict[Among, Bool[np.ndarray, " k"]]
    """Overlapping pairs that belong to each kind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Collisions:
    """Counts of one scene, or sums over several."""

    n_scenes: int
    n_colliding_scenes: int
    rate_sum: float
    """Sum over the scenes of the share of pairs that collide."""
    n_objects: int
    n_colliding_objects: int
    n_deep_objects: int
    """Objects that reach deeper than `MAX_DEPTH_M` into another."""
    n_collisions: int
    depth_sum_m: float
    """Sum of the depths of the pairs that collide."""

    @property
    def rate(self) -> float:
        """Share of pairs with an IoU above 0.01.

        It is the mean over scenes, as in the paper, so that a large scene counts as much as a small
        one.
        """
        return self.rate_sum / max(self.n_scenes, 1)

    @property
    def object_share(self) -> float:
        """Share of objects that collide with any other."""
        return self.n_colliding_objects / max(self.n_objects, 1)

    @property
    def deep_object_share(self) -> float:
        """Share of objects that reach more than a centimetre into any other."""
        return self.n_deep_objects / max(self.n_objects, 1)

    @property
    def scene_share(self) -> float:
        """Share of scenes with any colliding pair."""
        return self.n_colliding_scenes / max(self.n_scenes, 1)

    @property
    def mean_depth_m(self) -> float:
        """Mean penetration depth of the pairs that collide; 0 if none does."""
        return self.depth_sum_m / max(self.n_collisions, 1)


def collision_rate(scene: Scene) -> float:
    """Share of all pairs of objects whose boxes have an IoU above 0.01, as in the paper."""
    return collisions(overlaps(scene_arrays(scene)), "all").rate


def overlaps(arrays: SceneArrays) -> Overlaps:
    """Find the pairs of boxes that share volume, with their exact IoU and penetration depth.

    Depth is computed first, because it is cheap and leaves out all pairs that only lie near each
    other.
    """
    p, q, s = arrays.centre_enu_m, arrays.quat_wxyz, arrays.size_m
    first, second = near_pairs(p, q, s)
    depth_m = penetration_depth(p[first], q[first], s[first], p[second], q[second], s[second])
    is_deep = depth_m > 0
    first, second, depth_m = first[is_deep], second[is_deep], depth_m[is_deep]
    a, b = (p[first], q[first], s[first]), (p[second], q[second], s[second])
    n_all = arrays.n_objects * (arrays.n_objects - 1) // 2
    n_roots = int((arrays.parent < 0).sum())
    return Overlaps(
        n_objects=arrays.n_objects,
        n_pairs={
            "all": n_all,
            # Every object but a root has exactly one parent.
            "not parent and child": n_all - (arrays.n_objects - n_roots),
            "strangers": n_all - int(arrays.is_ancestor.sum()),
        },
        first=first,
        second=second,
        iou=pair_iou(*a, *b),
        depth_m=depth_m,
        is_among={
            "all": np.ones(len(first), dtype=bool),
            # Parents come before their children, so the second of a pair can only be the child.
            "not parent and child": arrays.parent[second] != first,
            "strangers": ~arrays.is_ancestor[first, second],
        },
    )


def collisions(found: Overlaps, among: Among) -> Collisions:
    """Count the collisions among the pairs of a kind.

    Args:
        found: Overlapping pairs of a scene.
        among: Kind of pairs to count.
    """
    looked_at = found.is_among[among]
    is_colliding = looked_at & (found.iou > MAX_IOU)
    is_deep = looked_at & (found.depth_m > MAX_DEPTH_M)
    n_collisions = int(is_colliding.sum())
    return Collisions(
        n_scenes=1,
        n_colliding_scenes=int(n_collisions > 0),
        rate_sum=n_collisions / max(found.n_pairs[among], 1),
        n_objects=found.n_objects,
        n_colliding_objects=_n_objects(found, is_colliding),
        n_deep_objects=_n_objects(found, is_deep),
        n_collisions=n_collisions,
        depth_sum_m=float(found.depth_m[is_colliding].sum()),
    )


def _n_objects(found: Overlaps, is_pair: np.ndarray) -> int:
    return len(np.union1d(found.first[is_pair], found.second[is_pair]))


def total(parts: Sequence[Collisions]) -> Collisions:
    """Add up the counts of several scenes.

    Shares of the sum weigh scenes by their objects, except `rate`, which is a mean over scenes.
    """
    # Every field is a count or a sum, so adding them field by field is right.
    names = [field.name for field in fields(Collisions)]
    return Collisions(**{name: sum(getattr(part, name) for part in parts) for name in names})
