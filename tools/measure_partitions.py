"""Figures of how well partition trees fit a corpus, and how exactly they build it again.

    python tools/measure_partitions.py corpus --scenes 0:400
    python tools/measure_partitions.py corpus --scenes 0:100 --jitter-m 0.3   # the null

Prints JSON: shares of sites by the nodes that they take, round trip errors in mm, lengths of the
sequences and how many symbols they have. Jitter tells how much of the fit is due to trees that can
fit anything: sites whose covers were moved at random should fit badly.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from aeroscene.corpus.dataset import open_dataset
from aeroscene.partition import (
    PartitionError,
    build_site,
    build_storeys,
    building_partitions,
    from_sequence,
    site_partition,
    to_sequence,
)
from aeroscene.partition.tree import Bend, Cross, Node, Overlay, Pinwheel, walk
from aeroscene.scene import OrientedBox, Scene
from aeroscene.scene.catalogue import GROUND
from aeroscene.sources import load_scene


def hardest(tree: Node) -> str:
    """Name of the most general kind of node in a tree, which no simpler kind could replace."""
    nodes = list(walk(tree))
    # A fallback is the grid that is taken where nothing else fits.
    if any(isinstance(n, Cross) and n.is_fallback for n in nodes):
        return "grid"
    for kind in (Bend, Pinwheel, Overlay):
        if any(isinstance(n, kind) for n in nodes):
            return kind.__name__.lower()
    return "slice"


def errors_mm(wanted: list[OrientedBox], found: list[OrientedBox]) -> list[float]:
    """For each wanted box, how far its corners lie from the box built in its place, mm.

    Args:
        wanted: Boxes of the scene.
        found: Boxes that the tree builds, one at least if any are wanted.
    """
    if not wanted:
        return []
    nearest = np.atleast_1d(KDTree([b.p for b in found]).query([b.p for b in wanted])[1])
    pairs = [(a.corners(), found[i].corners()) for a, i in zip(wanted, nearest, strict=True)]
    # Corners may come in another order, so that each takes the nearest one; the worst counts.
    return [1e3 * np.abs(a[:, None] - b[None]).max(axis=2).min(axis=1).max() for a, b in pairs]


def jittered(scene: Scene, jitter_m: float) -> Scene:
    """Copy of a scene with each cover moved at random along both axes.

    Args:
        scene: Scene; its seed draws the moves.
        jitter_m: Greatest move.
    """
    rng = np.random.default_rng(scene.seed)
    objects = []
    for obj in scene.objects:
        dx, dy = rng.uniform(-jitter_m, jitter_m, 2)
        if obj.category in GROUND:
            x, y, z = obj.bbox.p
            obj = replace(obj, bbox=replace(obj.bbox, p=(x + dx, y + dy, z)))  # noqa: PLW2901
        objects.append(obj)
    return replace(scene, objects=tuple(objects))


def measure(scenes: list[Scene]) -> dict[str, object]:
    """Measure scenes.

    Returns:
        Counts of nodes, errors and lengths as median, 95% and maximum, and the number of symbols.
    """
    counts: Counter[str] = Counter()
    symbols: set[object] = set()
    errors: dict[str, list[float]] = {"covers": [], "rooms_walls": []}
    lengths: dict[str, list[int]] = {"site": [], "storey": []}
    for scene in scenes:
        boxes = {obj.id: obj.bbox for obj in scene.objects}
        try:
            parsed = site_partition(scene)
        except PartitionError:
            counts["site none fits"] += 1
            parsed = None
        buildings = building_partitions(scene)
        partitions = [storey for building in buildings for storey in building.storeys]
        counts["storeys"] += len(partitions)
        counts["walls on no border"] += sum(len(b.free_wall_ids) for b in buildings)
        for storey in partitions:
            counts[f"storey {hardest(storey.tree)}"] += 1
        if parsed:
            counts[f"site {hardest(parsed.site.tree)}"] += 1
            built = [cover.box for cover in build_site(parsed.site)]
            errors["covers"] += errors_mm([boxes[i] for i in parsed.object_ids], built)
        for b in buildings:
            built = [part.box for part in build_storeys(b.storeys)]
            errors["rooms_walls"] += errors_mm([boxes[i] for i in b.object_ids], built)
        for partition in [*partitions, *([parsed.site] if parsed else [])]:
            records = to_sequence(partition)
            counts["sequences not exact"] += from_sequence(records) != partition
            lengths["storey" if partition in partitions else "site"].append(len(records))
            # A symbol is a record without its numbers.
            symbols |= {replace(record, share=0.0, values=()) for record in records}
    return {
        "counts": dict(sorted(counts.items())),
        "error_mm": {
            k: np.percentile(v, (50, 95, 100)).round(3).tolist() for k, v in errors.items() if v
        },
        "length": {k: np.percentile(v, (50, 95, 100)).tolist() for k, v in lengths.items() if v},
        "symbols": len(symbols),
    }


def main() -> None:
    """Measure the scenes of the command line, and print the figures as JSON."""
    parser = argparse.ArgumentParser(description="how well partition trees fit a corpus")
    parser.add_argument("data", help="folder of a corpus, or the word corpus for corpus:N")
    parser.add_argument("--scenes", default="0:100", help="A up to and without B")
    parser.add_argument("--jitter-m", type=float, default=0.0)
    args = parser.parse_args()
    low, high = map(int, args.scenes.split(":"))
    if args.data == "corpus":
        scenes = [load_scene(f"corpus:{index}") for index in range(low, high)]
    else:
        scenes = list(open_dataset(args.data).scenes())[low:high]
    if args.jitter_m:
        scenes = [jittered(scene, args.jitter_m) for scene in scenes]
    print(json.dumps(measure(scenes), indent=2))


if __name__ == "__main__":
    main()
