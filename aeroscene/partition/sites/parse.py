"""Reading of a site's partition off the boxes of its ground covers.

Covers side by side divide the site. Covers on another cover divide it, or have a place on it. A
site whose covers fit no slices, crosses or pinwheels may have a street that bends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import shapely

from aeroscene.partition.fit import SAME_M, Piece, Widths, fit, number_merges
from aeroscene.partition.frames import Bounds, Frame, frame_of, hull_of, nearest_quarter
from aeroscene.partition.sites.bend import fit_bend
from aeroscene.partition.sites.site import SitePartition
from aeroscene.partition.tree import Item, Leaf, Node, Overlay, PartitionError, Place
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import GROUND, STRIPS

# Headings that differ by less are aligned.
ALIGNED_RAD = 2e-3
_CONTAINED = 0.99
"""Least share of a cover's outline within the cover that it lies on."""
_TILED = 0.6
"""Children that cover a smaller share of a cover do not divide it."""
# Heights that differ by less are equal.
_ON_TOP_M = 0.006

Word = Callable[[SceneObject], str]


def category_word(obj: SceneObject) -> str:
    """Return the kind of a leaf: the object's category."""
    return obj.category


@dataclass(frozen=True, slots=True)
class ParsedSite:
    """A site's partition, and the objects of the scene that it stands for."""

    site: SitePartition
    object_ids: frozenset[int]


def site_partition(scene: Scene, word: Word = category_word) -> ParsedSite | None:
    """Read the partition of a scene's ground, by boxes, categories and parents alone.

    Covers without a parent divide the site. Covers that divide the upper face of another one do so
    on it. Covers that lie within their bearer have a place on it. Other objects on a cover are no
    part of the partition.

    Args:
        scene: Any scene.
        word: Kind of the leaf that an object becomes.

    Returns:
        None if the ground has no covers.

    Raises:
        PartitionError: If covers overlap in a way that no node has.
    """
    covers = [obj for obj in scene.objects if obj.category in GROUND and obj.domain == "outdoor"]
    roots = [obj for obj in covers if _is_root(scene, obj)]
    if not roots:
        return None
    reader = _Reader(scene, word, Widths(STRIPS))
    # The longest strip sets the heading of the site, or the longest cover without any strip.
    longest = max(roots, key=lambda o: (o.category in STRIPS, max(o.bbox.s[:2])))
    bodies, carried = reader.stacked(roots)
    try:
        frame, tree = reader.tree(bodies, carried, longest.bbox.yaw_rad)
    except PartitionError:
        # Straight sites are far more frequent, so the bend is the second attempt.
        bent = fit_bend(
            bodies, lambda obj, yaw: reader.node(obj, carried, yaw), reader.widths, word
        )
        if bent is None:
            raise
        frame, tree = bent
        reader.used.update(obj.id for obj in bodies)
    base_m = min(obj.bbox.p[2] - obj.bbox.s[2] / 2 for obj in bodies)
    site = SitePartition(frame=frame, tree=number_merges(tree), base_m=base_m)
    return ParsedSite(site, frozenset(reader.used))


def _is_root(scene: Scene, obj: SceneObject) -> bool:
    """True if a cover lies on bare ground: without a parent, or continuing one without."""
    if obj.parent_id is None:
        return True
    parent = scene.object_by_id[obj.parent_id]
    is_level = abs(_base(parent) - _base(obj)) < _ON_TOP_M
    return is_level and parent.category == obj.category and _is_root(scene, parent)


@dataclass(slots=True)
class _Reader:
    scene: Scene
    word: Word
    widths: Widths
    used: set[int] = field(default_factory=set)
    """Ids of the objects that are in a tree."""

    def stacked(
        self, objects: Sequence[SceneObject]
    ) -> tuple[list[SceneObject], dict[int, list[SceneObject]]]:
        """Return objects side by side, and those that lie on them by the ids of these."""
        bodies: list[SceneObject] = []
        carried: dict[int, list[SceneObject]] = {}
        # The largest first, so that a host is known before the objects on it.
        for obj in sorted(objects, key=lambda o: -o.bbox.s[0] * o.bbox.s[1]):
            host = next((body for body in bodies if _lies_on(obj, body)), None)
            if host is None:
                bodies.append(obj)
            else:
                carried.setdefault(host.id, []).append(obj)
        return sorted(bodies, key=lambda o: o.id), carried

    def tree(
        self,
        bodies: Sequence[SceneObject],
        carried: dict[int, list[SceneObject]],
        yaw_rad: float,
        host: Frame | None = None,
    ) -> tuple[Frame, Node]:
        """Return the tree of covers side by side, over their hull or over their bearer.

        Args:
            bodies: The covers.
            carried: Covers on them, by their ids.
            yaw_rad: Heading of the tree's frame.
            host: Frame of the bearer; None for covers on bare ground.
        """
        plane = host or Frame(0.0, 0.0, yaw_rad, 0.0, 0.0)
        pieces: list[Piece] = []
        for obj in bodies:
            _, rest = nearest_quarter(obj.bbox.yaw_rad - plane.yaw_rad)
            if abs(rest) > ALIGNED_RAD:
                raise PartitionError(f"object {obj.id} is turned by {rest:.3f} rad; valid: aligned")
            node = self.node(obj, carried, plane.yaw_rad)
            pieces.append(Piece(plane.bounds_of(frame_of(obj.bbox)), node, obj.id + 1))
        hull: Bounds = hull_of(piece.bounds for piece in pieces)
        if host:
            # Bare strips at the rim of the bearer become void leaves.
            hull = hull_of((hull, (0.0, 0.0, host.length_m, host.width_m)))
        tree = fit(pieces, self.widths, hull)
        self.used.update(obj.id for obj in bodies)
        return plane.inner(hull), tree

    def node(
        self, obj: SceneObject, carried: dict[int, list[SceneObject]], yaw_rad: float | None = None
    ) -> Leaf | Overlay:
        """Return a cover's leaf in a frame of a heading, with the covers on it.

        Args:
            obj: The cover.
            carried: Covers on covers, by the ids of the latter.
            yaw_rad: Heading of the frame; None takes the cover's own.
        """
        frame = frame_of(obj.bbox, yaw_rad)
        quarter, _ = nearest_quarter(obj.bbox.yaw_rad - frame.yaw_rad)
        leaf = Leaf(self.word(obj), obj.bbox.s[2], quarter)
        items = [self._item(other, frame) for other in carried.get(obj.id, [])]
        divided = self._divided(obj, frame)
        items += [Item(divided)] if divided else []
        return Overlay(leaf, tuple(items)) if items else leaf

    def _item(self, obj: SceneObject, host: Frame) -> Item:
        """Return a cover that lies on another at a place of its own."""
        u, v = host.local(obj.bbox.p[0], obj.bbox.p[1])
        size = (obj.bbox.s[0], obj.bbox.s[1])
        turn = obj.bbox.yaw_rad - host.yaw_rad
        self.used.add(obj.id)
        place = Place(u / host.length_m, v / host.width_m, turn, size)
        return Item(self.node(obj, {}), place)

    def _divided(self, host: SceneObject, frame: Frame) -> Node | None:
        """Return the tree of covers on the upper face of another; None if it is mostly bare."""
        top_m = host.bbox.p[2] + host.bbox.s[2] / 2
        bodies = [
            child
            for child in self.scene.children_by_id.get(host.id, ())
            if child.category in GROUND
            and abs(_base(child) - top_m) < _ON_TOP_M
            and abs(nearest_quarter(child.bbox.yaw_rad - frame.yaw_rad)[1]) < ALIGNED_RAD
        ]
        bodies, carried = self.stacked(bodies)
        area = sum(child.bbox.s[0] * child.bbox.s[1] for child in bodies)
        if area < _TILED * frame.length_m * frame.width_m:
            return None
        inside = all(_is_within(frame.bounds_of(frame_of(child.bbox)), frame) for child in bodies)
        if not inside:
            raise PartitionError(f"a child of object {host.id} reaches over it; valid: none does")
        return self.tree(bodies, carried, frame.yaw_rad, frame)[1]


def _base(obj: SceneObject) -> float:
    return obj.bbox.p[2] - obj.bbox.s[2] / 2


def _lies_on(obj: SceneObject, host: SceneObject) -> bool:
    """True if a cover's underside lies on another one and within its outline."""
    top_m = host.bbox.p[2] + host.bbox.s[2] / 2
    if abs(_base(obj) - top_m) > _ON_TOP_M:
        return False
    # Corners 0, 1, 3, 2 go around the lower face.
    inner, outer = (shapely.Polygon(o.bbox.corners()[[0, 1, 3, 2], :2]) for o in (obj, host))
    return outer.intersection(inner).area >= _CONTAINED * inner.area


def _is_within(bounds: Bounds, frame: Frame) -> bool:
    x0, y0, x1, y1 = bounds
    limit = (frame.length_m + SAME_M, frame.width_m + SAME_M)
    return x0 >= -SAME_M and y0 >= -SAME_M and x1 <= limit[0] and y1 <= limit[1]
