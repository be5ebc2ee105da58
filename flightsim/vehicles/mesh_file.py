"""Mesh files of bodies, STL and OBJ, read by MuJoCo; ASCII STL is read here, facet by facet.

CAD programs export STL as text by default, which MuJoCo does not read. trimesh does, but takes 300
MB for a file of 16 MiB, and 90 MB before it has read any.
"""

from __future__ import annotations

import functools
import re
from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from aeroscene.files import UnpackError, read_bounded

SUFFIXES = (".stl", ".obj")
_MOST_BYTES = 16 << 20
"""Most bytes of a file: a binary STL of 200,000 faces, MuJoCo's most, has 10 MB."""
_MOST_REACH_M = 10.0
"""Greatest distance of a vertex from the file's origin: twice the longest vehicle."""
# Bounded repetitions: a damaged file must fail quickly, not be searched for ever.
_CORNER = rb"vertex" + rb"\s+(\S{1,40})" * 3 + rb"\s+"
_FACET = re.compile(
    rb"\s*facet\s+normal(?:\s+\S{1,40}){3}\s+outer\s+loop\s+"
    + _CORNER * 3
    + rb"endloop\s+endfacet\b",
    re.IGNORECASE,
)
_NAME_END = re.compile(rb"\bfacet\s+normal\b|\bendsolid\b", re.IGNORECASE)
_END = re.compile(rb"\s*endsolid\b[^\n]*", re.IGNORECASE)
_HEAD_BYTES, _FACE_BYTES = 84, 50
"""Bytes of the head and of a face of a binary STL."""


class MeshFileError(ValueError):
    """A mesh cannot be read; one line says why, and what would be valid."""


def mesh_source(path: str) -> Mapping[str, Any]:
    """Return the arguments of `MjSpec.add_mesh` that make it a file's mesh.

    Args:
        path: The file.

    Raises:
        MeshFileError: If the file cannot be read, or is damaged.
    """
    try:
        changed_ns = Path(path).stat().st_mtime_ns
    except OSError as error:
        raise MeshFileError(f"{error.strerror or error}; valid: a mesh that is there") from None
    return _source(path, changed_ns)


def check_mesh(path: str, scale: float) -> None:
    """Refuse a file that would fail when a world is built.

    Args:
        path: The file.
        scale: Size of the file's unit in metres.

    Raises:
        MeshFileError: If it is damaged, has no surface, or is larger than any vehicle.
    """
    spec = mujoco.MjSpec()
    shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.add_mesh(name="mesh", inertia=shell, scale=(scale, scale, scale), **mesh_source(path))
    kind = {"type": mujoco.mjtGeom.mjGEOM_MESH, "contype": 0, "conaffinity": 0, "mass": 0.0}
    geom = spec.worldbody.add_geom(meshname="mesh", **kind)
    assert geom is not None
    try:
        model = spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).partition("\n")[0].removeprefix("Error: ").split())
        raise MeshFileError(f"{reason}; valid: a whole STL or OBJ file with a surface") from None
    # MuJoCo moves a mesh to its centre; mesh_pos is where that was in the file.
    reach_m = float(np.abs(model.mesh_vert + model.mesh_pos[0]).max())
    if not reach_m <= _MOST_REACH_M:
        raise MeshFileError(
            f"it reaches {reach_m:.3g} m from its origin; valid: up to {_MOST_REACH_M:g} m, so "
            "a file in millimetres has scale = 0.001"
        )


@functools.lru_cache(maxsize=4)
def _source(path: str, _changed_ns: int) -> Mapping[str, Any]:
    if not path.lower().endswith(".stl"):
        if Path(path).stat().st_size > _MOST_BYTES:
            raise MeshFileError(f"it holds more than {_MOST_BYTES >> 20} MiB; valid: at most that")
        return {"file": path}
    try:
        data = read_bounded(Path(path), _MOST_BYTES)
    except OSError as error:
        raise MeshFileError(f"{error.strerror or error}; valid: a mesh that is there") from None
    except UnpackError as error:
        raise MeshFileError(f"it {error}") from None
    return _ascii_surface(data) if _is_ascii(data) else {"file": path}


def _is_ascii(data: bytes) -> bool:
    """Return true if an STL is text; by its length, as binary ones may begin with `solid` too."""
    n_faces = int.from_bytes(data[_HEAD_BYTES - 4 : _HEAD_BYTES], "little")
    is_binary = len(data) == _HEAD_BYTES + _FACE_BYTES * n_faces
    return data.lstrip()[:5].lower() == b"solid" and not is_binary


def _ascii_surface(data: bytes) -> Mapping[str, Any]:
    """Return the arguments of `MjSpec.add_mesh` for the facets of an ASCII STL."""
    corners = array("d")
    end = 0
    try:
        while (end := _skip_name(data, end)) < len(data):
            while facet := _FACET.match(data, end):
                corners.extend(map(float, facet.groups()))
                end = facet.end()
            end = _require_end(data, end)
    except ValueError:
        corners = array("d")
    points = np.frombuffer(corners, dtype=float).reshape(-1, 3) if corners else np.zeros((0, 3))
    if not len(points) or not np.isfinite(points).all():
        raise MeshFileError("it is no ASCII STL; valid: facets of three vertices, whole")
    # Neighbours share their vertices, which the file repeats.
    vertices, faces = np.unique(points, axis=0, return_inverse=True)
    return {"uservert": vertices.ravel(), "userface": faces.ravel().astype(np.int32)}


def _skip_name(data: bytes, start: int) -> int:
    """Return the place of the first facet of the solid at `start`; the end without one."""
    if not data[start:].strip():
        return len(data)
    head = _NAME_END.search(data, start)
    if head is None or data[start : head.start()].split(maxsplit=1)[0].lower() != b"solid":
        raise ValueError
    return head.start()


def _require_end(data: bytes, start: int) -> int:
    """Return the end of the line that closes a solid and begins at `start`."""
    end = _END.match(data, start)
    if end is None:
        raise ValueError
    return end.end()
