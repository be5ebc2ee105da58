"""A vehicle's body in a URDF or MJCF file, read by MuJoCo's own compiler.

Only the shapes of the bodies in their resting pose count, and the masses if the file states them.
Joints, motors, sensors and the file's world do not. The frame is that of its topmost body: forward,
left, up. MuJoCo's compiler resolves what such files may contain (defaults, includes, meshes), which
a reader of our own would have to repeat. Files may come from strangers, so size, number and nesting
are bounded first.
"""

from __future__ import annotations

import functools
import itertools
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Float, Int

from aeroscene.files import UnpackError, read_bounded
from autonomy.types import Quaternion, Vector3

SUFFIXES = (".urdf", ".xml")
# Elements that make any number of shapes out of one line.
_MULTIPLYING = frozenset(("composite", "flexcomp", "hfield", "replicate", "skin"))
_MOST_ELEMENTS = 2_000
_DEEPEST = 4
_PACKAGE = "package://"
_MOST_BYTES = 4 << 20
"""Most bytes of a file, which names its meshes and does not hold them."""
_SHAPES = frozenset(
    {
        mujoco.mjtGeom.mjGEOM_SPHERE,
        mujoco.mjtGeom.mjGEOM_CAPSULE,
        mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        mujoco.mjtGeom.mjGEOM_CYLINDER,
        mujoco.mjtGeom.mjGEOM_BOX,
        mujoco.mjtGeom.mjGEOM_MESH,
    }
)


class BodyFileError(ValueError):
    """A file describes no body; one line says why."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyPart:
    """A shape of a body, in the file's frame."""

    shape: mujoco.mjtGeom
    size_m: Vector3
    """Half extents, as MuJoCo has them; without meaning for a mesh."""
    position_m: Vector3
    quat_wxyz: Quaternion
    rgba: tuple[float, float, float, float]
    is_solid: bool
    """True if the file lets it touch things; other parts are visible only."""
    corners_m: Float[np.ndarray, "8 3"]
    """Corners of a box around it, turned as the part is, in the file's frame."""
    vertices_m: Float[np.ndarray, "n 3"] | None = None
    """Vertices of a mesh about its position and attitude."""
    faces: Int[np.ndarray, "m 3"] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyMass:
    """Mass of a whole body."""

    mass_kg: float
    centre_m: Float[np.ndarray, " 3"]
    """Centre of mass in the file's frame."""
    inertia_kgm2: Float[np.ndarray, "3 3"]
    """Moments about the centre of mass, along the axes of the file's frame."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyFile:
    """Content of a file: the body's parts and its mass."""

    parts: tuple[BodyPart, ...]
    mass: BodyMass | None
    """None if neither an inertial element nor a shape states a mass."""

    @property
    def looks(self) -> tuple[BodyPart, ...]:
        """Visible parts: those that touch nothing, or all parts if all do."""
        return tuple(part for part in self.parts if not part.is_solid) or self.parts

    @property
    def solids(self) -> tuple[BodyPart, ...]:
        """Parts that can touch obstacles."""
        return tuple(part for part in self.parts if part.is_solid)


def read_body_file(path: Path) -> BodyFile:
    """Read a URDF or MJCF file with one body and its parts.

    Args:
        path: The file; meshes are looked for beside it.

    Raises:
        BodyFileError: If it cannot be read, or has no such body.
    """
    try:
        # The time of the last change belongs to the key, so that an edited file is read again.
        return _read(path, path.stat().st_mtime_ns)
    except OSError as error:
        raise BodyFileError(error.strerror or str(error)) from None
    except UnpackError as error:
        raise BodyFileError(f"it {error}") from None
    except RecursionError:
        raise BodyFileError("it is nested too deeply; bodies in bodies are valid") from None


def add_parts(
    spec: mujoco.MjSpec,
    body: Any,
    parts: Sequence[BodyPart],
    position_flu_m: Vector3,
    name: str,
    kind: Mapping[str, Any],
) -> None:
    """Add parts to a vehicle's body as geoms.

    Args:
        spec: World of the body.
        body: The body, forward, left, up.
        parts: Parts of a file.
        position_flu_m: Place of the file's origin in the body frame.
        name: Beginning of their names; a number follows.
        kind: Properties of all of these geoms besides shape and colour.
    """
    for i, part in enumerate(parts):
        shape: dict[str, Any] = {"size": part.size_m}
        if part.vertices_m is not None and part.faces is not None:
            spec.add_mesh(
                name=f"{name}{i}",
                uservert=part.vertices_m.ravel(),
                userface=part.faces.ravel(),
                # Its surface is enough: a mesh need not be closed, and its mass is not asked for.
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
            shape = {"meshname": f"{name}{i}"}
        body.add_geom(
            name=f"{name}{i}",
            type=part.shape,
            pos=np.add(position_flu_m, part.position_m),
            quat=part.quat_wxyz,
            rgba=part.rgba,
            **shape,
            **kind,
        )


@functools.lru_cache(maxsize=16)
def _read(path: Path, _changed_ns: int) -> BodyFile:
    try:
        spec = _urdf(path) if path.suffix.lower() == ".urdf" else _mjcf(path)
        _stand_still(spec)
        states_mass = _count_stated_masses_only(spec)
        model = spec.compile()
    except (ValueError, ET.ParseError) as error:
        raise BodyFileError(" ".join(str(error).split())) from None
    tops = np.flatnonzero(model.body_parentid == 0)[1:]
    if len(tops) != 1:
        raise BodyFileError(f"it has {len(tops)} bodies in its world; one is valid")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    top = int(tops[0])
    shown = np.flatnonzero(model.geom_bodyid > 0)
    parts = tuple(_part(model, data, int(geom), top) for geom in shown)
    if not parts:
        raise BodyFileError("its body has no shape")
    return BodyFile(parts=parts, mass=_mass(model, data, top) if states_mass else None)


def _checked(path: Path, depth: int = 0) -> ET.Element:
    """Return the topmost element of a file, after checks of its size and its includes.

    Raises:
        BodyFileError: If it has too many elements, or one that makes any number of others.
        OSError: If it cannot be read.
    """
    # Expat refuses entities that grow without end.
    root = ET.fromstring(read_bounded(path, _MOST_BYTES))  # noqa: S314
    for number, element in enumerate(root.iter()):
        if number > _MOST_ELEMENTS:
            raise BodyFileError(f"it has more than {_MOST_ELEMENTS} elements; fewer are valid")
        if element.tag in _MULTIPLYING:
            raise BodyFileError(f"it has <{element.tag}>; shapes one by one are valid")
        if element.tag == "include":
            if depth >= _DEEPEST:
                raise BodyFileError(f"it includes files deeper than {_DEEPEST} times")
            _checked(path.parent / element.get("file", ""), depth + 1)
    return root


def _mjcf(path: Path) -> mujoco.MjSpec:
    _checked(path)
    spec = mujoco.MjSpec.from_file(str(path))
    # No joint stays, so that every body would be fused into the world.
    spec.compiler.fusestatic = False
    return spec


def _urdf(path: Path) -> mujoco.MjSpec:
    """Return the file with what MuJoCo would leave out by default: looks, and the base's mass."""
    root = _checked(path)
    if root.tag != "robot":
        raise BodyFileError(f"its topmost element is {root.tag!r}; in a URDF file robot is valid")
    extension = root.find("mujoco")
    if extension is None:
        extension = ET.SubElement(root, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = ET.SubElement(extension, "compiler")
    compiler.attrib |= {
        "discardvisual": "false",
        "fusestatic": "false",
        "strippath": "false",
        "meshdir": str(path.parent),
    }
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(_mesh_file(path.parent, mesh.get("filename", ""))))
    return mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))


def _mesh_file(folder: Path, named: str) -> Path:
    """Return the file of a mesh: `package://NAME/REST` is REST in the URDF's folder or above it."""
    if not named.startswith(_PACKAGE):
        return folder / named.removeprefix("file://")
    rest = named.removeprefix(_PACKAGE).partition("/")[2]
    found = (above / rest for above in (folder, *folder.parents) if (above / rest).is_file())
    return next(found, folder / rest)


def _stand_still(spec: mujoco.MjSpec) -> None:
    """Remove everything that moves, measures or is posed."""
    for kind in ("keys", "sensors", "actuators", "tendons", "equalities", "excludes", "pairs"):
        for element in list(getattr(spec, kind)):
            spec.delete(element)
    for joint in list(spec.joints):
        spec.delete(joint)
    # Only colours count; a texture may be of any size, and its file may be anything.
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)


def _count_stated_masses_only(spec: mujoco.MjSpec) -> bool:
    """Let shapes without a mass of their own weigh nothing; return true if anything has a mass."""
    states = any(body.explicitinertial for body in spec.bodies)
    for geom in spec.geoms:
        # MuJoCo would give them the density of water.
        if np.isnan(geom.mass):
            geom.mass = 0.0
        states |= geom.mass > 0.0
    return bool(states)


def _part(model: mujoco.MjModel, data: mujoco.MjData, geom: int, top: int) -> BodyPart:
    shape = mujoco.mjtGeom(int(model.geom_type[geom]))
    if shape not in _SHAPES:
        valid = "spheres, capsules, ellipsoids, cylinders, boxes and meshes are valid"
        raise BodyFileError(f"its body has a shape {shape.name[7:].lower()}; {valid}")
    # Into the frame of the topmost body.
    rotation = data.xmat[top].reshape(3, 3)
    x, y, z = (rotation.T @ (data.geom_xpos[geom] - data.xpos[top])).tolist()
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, (rotation.T @ data.geom_xmat[geom].reshape(3, 3)).ravel())
    qw, qx, qy, qz = turn.tolist()
    a, b, c = model.geom_size[geom].tolist()
    red, green, blue, alpha = _rgba(model, geom).tolist()
    part = {
        "shape": shape,
        "size_m": (a, b, c),
        "position_m": (x, y, z),
        "quat_wxyz": (qw, qx, qy, qz),
        "rgba": (red, green, blue, alpha),
        "is_solid": bool(model.geom_contype[geom] or model.geom_conaffinity[geom]),
        "corners_m": _corners_m(model, data, geom, top),
    }
    if shape != mujoco.mjtGeom.mjGEOM_MESH:
        return BodyPart(**part)
    mesh = int(model.geom_dataid[geom])
    vertices = _rows(model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum, mesh)
    faces = _rows(model.mesh_face, model.mesh_faceadr, model.mesh_facenum, mesh)
    return BodyPart(**part, vertices_m=vertices.astype(np.float64), faces=faces)


def _corners_m(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, top: int
) -> Float[np.ndarray, "8 3"]:
    middle_m, half_m = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    own_m = middle_m + signs * half_m
    world_m = data.geom_xpos[geom] + own_m @ data.geom_xmat[geom].reshape(3, 3).T
    return (world_m - data.xpos[top]) @ data.xmat[top].reshape(3, 3)


def _rgba(model: mujoco.MjModel, geom: int) -> np.ndarray:
    material = int(model.geom_matid[geom])
    return model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]


def _rows(all_rows: np.ndarray, first: np.ndarray, count: np.ndarray, index: int) -> np.ndarray:
    return all_rows[first[index] : first[index] + count[index]].copy()


def _mass(model: mujoco.MjModel, data: mujoco.MjData, top: int) -> BodyMass:
    mass_kg = model.body_mass[top:]
    centre_m = mass_kg @ data.xipos[top:] / mass_kg.sum()
    inertia_kgm2 = np.zeros((3, 3))
    for body in range(top, model.nbody):
        axes = data.ximat[body].reshape(3, 3)
        away_m = data.xipos[body] - centre_m
        # Parallel axes: the moment of a point mass away from the common centre.
        around = np.eye(3) * (away_m @ away_m) - np.outer(away_m, away_m)
        inertia_kgm2 += axes @ np.diag(model.body_inertia[body]) @ axes.T
        inertia_kgm2 += model.body_mass[body] * around
    rotation = data.xmat[top].reshape(3, 3)
    return BodyMass(
        mass_kg=float(mass_kg.sum()),
        centre_m=rotation.T @ (centre_m - data.xpos[top]),
        inertia_kgm2=rotation.T @ inertia_kgm2 @ rotation,
    )
