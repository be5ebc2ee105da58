"""Cache of distance fields: in this process, and on disk for later ones.

Computing the field of a scene takes longer than loading it, and a campaign flies in the same scene
hundreds of times. A field is kept under a hash of everything that it follows from: the solids, the
relief, the flight volume, the cells and the code that computes it. It therefore never has to be
invalidated. A file that is damaged or of another version counts as missing.

The folder `fields` of the user's cache (or of `AEROSCENE_CACHE_DIR`) holds up to 200 MB; the files
that were not used for longest go first. `AEROSCENE_CACHE=off` reads and writes no file.
"""

from __future__ import annotations

import functools
import hashlib
import io
import os
import zlib
from collections import OrderedDict
from collections.abc import Sequence
from math import ceil
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from aeroscene.files import cache_folder, replacing
from aeroscene.scene import Scene, relief
from aeroscene.solids import freespace, ground, solids, voxels
from aeroscene.solids.freespace import MAX_DISTANCE_M, VoxelField, build_distance_field
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.wide_field import WideField

BUDGET_BYTES = 200_000_000
# Fields kept in memory: a process that flies in turn through a few scenes does not recompute.
_KEPT_IN_PROCESS = 4
_MAGIC = b"aeroscene field 1\n"
_DIGEST_BYTES = 16
_DAMAGED = (OSError, ValueError, EOFError, KeyError, zlib.error)

_of_process: OrderedDict[str, VoxelField] = OrderedDict()
_wide: dict[str, WideField] = {}
"""Field of the last large scene; one may hold a gigabyte."""


def cached_distance_field(
    scene: Scene,
    resolution_m: float,
    primitives: Sequence[Primitive],
    cap_m: float = MAX_DISTANCE_M,
) -> VoxelField:
    """Return `build_distance_field` of a scene, from the cache if possible.

    Several flights share the array, so callers must not write to it.

    Args:
        scene: Scene.
        resolution_m: Edge of a cell.
        primitives: The scene's primitives.
        cap_m: Distance at which values are capped.
    """
    key = _key(scene, resolution_m, primitives, cap_m)
    # Taken out and put back at the end, which keeps the dictionary ordered by last use.
    field = _of_process.pop(key, None)
    if field is None:
        field = _from_disk_or_new(key, scene, resolution_m, primitives, cap_m)
    _of_process[key] = field
    while len(_of_process) > _KEPT_IN_PROCESS:
        _of_process.popitem(last=False)
    return field


def cached_wide_field(
    scene: Scene, resolution_m: float, primitives: Sequence[Primitive]
) -> WideField:
    """Field of a large scene together with the tiles that were computed of it so far.

    Only the last scene is kept, because one field may hold a gigabyte.
    """
    key = _key(scene, resolution_m, primitives, MAX_DISTANCE_M)
    field = _wide.get(key)
    if field is None:
        _wide.clear()
        field = _wide[key] = WideField(scene, resolution_m, primitives)
    return field


def forget() -> None:
    """Drop the fields of this process; files stay.

    For example, tests call it to measure what the files on disk save.
    """
    _of_process.clear()
    _wide.clear()


def _from_disk_or_new(
    key: str, scene: Scene, resolution_m: float, primitives: Sequence[Primitive], cap_m: float
) -> VoxelField:
    folder = cache_folder("fields")
    if folder is None:
        return build_distance_field(scene, resolution_m, primitives, cap_m)
    path = folder / f"{key}.field"
    try:
        field = _decode(path.read_bytes(), resolution_m, cap_m)
        # The modification time serves as time of last use: access times are often switched off.
        os.utime(path)
    except _DAMAGED:
        field = build_distance_field(scene, resolution_m, primitives, cap_m)
        _save(path, _encode(field, cap_m))
    return field


def _key(scene: Scene, resolution_m: float, primitives: Sequence[Primitive], cap_m: float) -> str:
    digest = hashlib.blake2b(_code(), digest_size=_DIGEST_BYTES)
    extents = (*scene.extent_min_enu_m, *scene.extent_max_enu_m)
    digest.update(np.array([*extents, resolution_m, cap_m]).tobytes())
    if scene.relief is not None:
        digest.update(np.array([*scene.relief.origin_enu_m, scene.relief.spacing_m]).tobytes())
        digest.update(np.array(scene.relief.heights_m.shape).tobytes())
        digest.update(scene.relief.heights_m.tobytes())
    for one in primitives:
        # Paint and other parts without contact do not change the field, hence do not change the
        # key.
        if one.collides:
            digest.update(f"{one.kind} {len(one.vertices_m)} ".encode())
            numbers = (*one.position_enu_m, *one.quat_wxyz, *one.size_m)
            digest.update(np.array(numbers).tobytes())
            digest.update(np.array(one.vertices_m, dtype=float).tobytes())
    return digest.hexdigest()


@functools.cache
def _code() -> bytes:
    """Hash of the code that a field follows from: a changed algorithm never finds old files."""
    digest = hashlib.blake2b(_MAGIC, digest_size=_DIGEST_BYTES)
    for module in (freespace, ground, relief, solids, voxels):
        digest.update(Path(str(module.__file__)).read_bytes())
    return digest.digest()


def _encode(field: VoxelField, cap_m: float) -> bytes:
    """Encode squared distances in units of half a cell, up to the highest layer that is not capped.

    Those squares are integers (see `distance_to_occupied`), so 16 bits hold them without loss, and
    they compress better than floats. Above the highest obstacle all cells are capped and need no
    bytes.
    """
    is_near = (field.distance_m < np.float32(cap_m)).any(axis=(0, 1))
    top = int(np.flatnonzero(is_near)[-1]) + 1 if is_near.any() else 0
    squares = np.rint((field.distance_m[:, :, :top] * (2 / field.resolution_m)) ** 2)
    squares[field.distance_m[:, :, :top] >= np.float32(cap_m)] = _capped(field.resolution_m, cap_m)
    payload = io.BytesIO()
    for array in (
        np.array(field.origin_enu_m),
        np.array(field.distance_m.shape),
        squares.astype(np.uint16),
    ):
        np.save(payload, array, allow_pickle=False)
    # the fastest level: writing must not delay the first flight
    body = zlib.compress(payload.getvalue(), 1)
    return _MAGIC + hashlib.blake2b(body, digest_size=_DIGEST_BYTES).digest() + body


def _decode(data: bytes, resolution_m: float, cap_m: float) -> VoxelField:
    """Decode the field that `_encode` wrote, equal to the bit.

    Raises:
        ValueError: If the data is not of this format and version.
    """
    head = len(_MAGIC) + _DIGEST_BYTES
    body = data[head:]
    if data[:head] != _MAGIC + hashlib.blake2b(body, digest_size=_DIGEST_BYTES).digest():
        raise ValueError("not a distance field of this version; valid: what was written here")
    payload = io.BytesIO(zlib.decompress(body))
    origin, shape, squares = (np.load(payload, allow_pickle=False) for _ in range(3))
    x, y, z = origin.tolist()
    distance_m = np.full(tuple(shape.tolist()), cap_m, dtype=np.float32)
    lookup = _distances(_capped(resolution_m, cap_m), resolution_m, cap_m)
    distance_m[:, :, : squares.shape[2]] = lookup[squares]
    return VoxelField(origin_enu_m=(x, y, z), resolution_m=resolution_m, distance_m=distance_m)


def _capped(resolution_m: float, cap_m: float) -> int:
    """Least square, in units of half a cell, whose root is the cap or more."""
    return ceil((2 * cap_m / resolution_m) ** 2)


def _distances(most: int, resolution_m: float, cap_m: float) -> Float[np.ndarray, " squares"]:
    """Distance of each square, by the same arithmetic as in `distance_to_occupied`."""
    squares: Int[np.ndarray, " squares"] = np.arange(most + 1)
    return np.minimum(np.sqrt(squares) * resolution_m / 2, cap_m).astype(np.float32)


def _save(path: Path, data: bytes) -> None:
    """Write a file and remove those beyond the budget that were not used for longest.

    A folder that cannot be written to is no error: the field is then computed anew each time.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Other processes may write and delete at the same time. The file therefore appears in one
        # step.
        with replacing(path) as file:
            file.write(data)
        files = [(one.stat().st_mtime, one.stat().st_size, one) for one in path.parent.iterdir()]
        total = 0
        for _, size, one in sorted(files, reverse=True):
            total += size
            if total > BUDGET_BYTES:
                one.unlink(missing_ok=True)
    except OSError:
        return
