"""Vehicle in a USD stage: a rigid body with mass, inertia, colliders, looks and cameras.

It has no rotors that push: the program that opens the stage brings its own forces.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from flightsim.export.meshes import pose_matrix
from flightsim.export.usd_prims import define_mesh, define_xform, label, set_pose
from flightsim.looks.geom_groups import GeomGroup
from flightsim.world import World

VEHICLE_PATH = "/World/Vehicle"
_GEOM = mujoco.mjtGeom
_SENSOR_HEIGHT_MM = 15.3
"""Height of the camera's film; with the field of view it gives the focal length."""
_ASPECT = 4.0 / 3.0


def add_vehicle(stage: Usd.Stage, world: World) -> None:
    """Add the vehicle of a world, standing at the start.

    Args:
        stage: Stage to add to.
        world: World with a vehicle, as that vehicle's view.
    """
    quadrotor = world.airframe.quadrotor
    pose = pose_matrix(tuple(world.rest_qpos[:3]), tuple(world.rest_qpos[3:7]))
    prim = define_xform(stage, VEHICLE_PATH, pose)
    label(prim, "drone")
    UsdPhysics.RigidBodyAPI.Apply(prim)
    mass = UsdPhysics.MassAPI.Apply(prim)
    mass.CreateMassAttr(quadrotor.mass_kg)
    # The body's frame is our FLU frame, whose axes are the principal ones.
    mass.CreateCenterOfMassAttr(Gf.Vec3f(0.0))
    mass.CreatePrincipalAxesAttr(Gf.Quatf(1.0))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*quadrotor.inertia_flu_kgm2))
    for scope in ("looks", "solids", "cameras"):
        UsdGeom.Scope.Define(stage, f"{VEHICLE_PATH}/{scope}")
    model = world.model
    for index in range(model.ngeom):
        if model.geom_bodyid[index] == world.vehicle_body_id:
            _add_geom(stage, model, index)
    for index in range(model.ncam):
        if model.cam_bodyid[index] == world.vehicle_body_id:
            _add_camera(stage, model, index)


def _add_geom(stage: Usd.Stage, model: mujoco.MjModel, index: int) -> None:
    is_solid = model.geom_group[index] == GeomGroup.VEHICLE_SHAPE
    path = f"{VEHICLE_PATH}/{'solids' if is_solid else 'looks'}/geom_{index}"
    size = model.geom_size[index].tolist()
    scale = None
    match model.geom_type[index]:
        case _GEOM.mjGEOM_BOX:
            gprim = UsdGeom.Cube.Define(stage, path)
            gprim.CreateSizeAttr(2.0)  # MuJoCo has half sizes: a cube from -1 to 1
            scale = tuple(size)
        case _GEOM.mjGEOM_CAPSULE:
            gprim = UsdGeom.Capsule.Define(stage, path)
            _set_round(gprim, size)
        case _GEOM.mjGEOM_CYLINDER:
            gprim = UsdGeom.Cylinder.Define(stage, path)
            _set_round(gprim, size)
        case _GEOM.mjGEOM_MESH:
            gprim = define_mesh(stage, path, *_mesh(model, model.geom_dataid[index]))
        case _:
            # An ellipsoid, only part of the looks.
            gprim = UsdGeom.Sphere.Define(stage, path)
            gprim.CreateRadiusAttr(1.0)
            scale = tuple(size)
    pose = pose_matrix(tuple(model.geom_pos[index]), tuple(model.geom_quat[index]))
    set_pose(gprim, pose, scale)
    if is_solid:
        gprim.CreatePurposeAttr(UsdGeom.Tokens.guide)
        UsdPhysics.CollisionAPI.Apply(gprim.GetPrim())
    else:
        red, green, blue, alpha = model.geom_rgba[index].tolist()
        gprim.CreateDisplayColorAttr([Gf.Vec3f(red, green, blue)])
        gprim.CreateDisplayOpacityAttr([alpha])


def _mesh(model: mujoco.MjModel, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n, 3) and the corners (f, 3) of a mesh of the model."""
    points, faces = model.mesh_vertadr[index], model.mesh_faceadr[index]
    return (
        model.mesh_vert[points : points + model.mesh_vertnum[index]],
        model.mesh_face[faces : faces + model.mesh_facenum[index]],
    )


def _set_round(gprim: Any, size: list[float]) -> None:
    """Set radius and length of a capsule or a cylinder; MuJoCo has half lengths."""
    gprim.CreateAxisAttr(UsdGeom.Tokens.z)
    gprim.CreateRadiusAttr(size[0])
    gprim.CreateHeightAttr(2 * size[1])


def _add_camera(stage: Usd.Stage, model: mujoco.MjModel, index: int) -> None:
    """Add a camera; USD's camera axes are MuJoCo's: x right, y up, looking along -z."""
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_CAMERA, index)
    camera = UsdGeom.Camera.Define(stage, f"{VEHICLE_PATH}/cameras/{name}")
    half_rad = math.radians(float(model.cam_fovy[index])) / 2
    camera.CreateVerticalApertureAttr(_SENSOR_HEIGHT_MM)
    camera.CreateHorizontalApertureAttr(_SENSOR_HEIGHT_MM * _ASPECT)
    camera.CreateFocalLengthAttr(_SENSOR_HEIGHT_MM / (2 * math.tan(half_rad)))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.03, 1000.0))
    pose = pose_matrix(tuple(model.cam_pos[index]), tuple(model.cam_quat[index]))
    set_pose(camera, pose)
