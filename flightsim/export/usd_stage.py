"""Stage of a world: its scene, its areas and its vehicle as prims."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, Vt

from aeroscene.neighbourhood import neighbours_of
from aeroscene.scene import InteractionArea, Relief, SceneObject
from aeroscene.solids.shapes import MATERIALS, Primitive
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.export.meshes import (
    ObjectMesh,
    Pose,
    area_facts,
    area_name,
    neighbour_skins,
    object_meshes,
    object_name,
    pose_matrix,
    scene_facts,
)
from flightsim.export.usd_prims import (
    define_material,
    define_mesh,
    define_solid,
    define_xform,
    describe,
    label,
    set_pose,
)
from flightsim.export.usd_vehicle import add_vehicle
from flightsim.looks.relief_ground import relief_surface
from flightsim.looks.tessellation import Surface
from flightsim.world import World

_AREA_LIFT_M = 0.02  # so that areas do not flicker with the surface below
_GROUND_HALF_M = 500.0  # how far the ground reaches; a stage has no endless mesh


def write_stage(world: World, path: Path) -> None:
    """Write the stage of a world, and its textures beside it.

    Args:
        world: World to write.
        path: File to write, ending in .usdc.
    """
    stage = Usd.Stage.CreateNew(str(path))
    _Writer(stage, world, path.parent).write()
    stage.GetRootLayer().Save()
    # The layer keeps the file open until `stage` is freed; another writer of the same name would
    # find it in memory.


class _Writer:
    """Writer that fills one stage."""

    def __init__(self, stage: Usd.Stage, world: World, folder: Path) -> None:
        self._stage = stage
        self._world = world
        self._folder = folder
        self._materials: dict[str, Any] = {}
        self._paths: dict[int | None, str] = {None: "/World/Objects"}  # objects without a parent

    def write(self) -> None:
        self._set_up()
        self._add_ground()
        for mesh in object_meshes(self._world.scene, self._world.solids):
            self._add_object(mesh)
        self._add_neighbours()
        for area in self._world.scene.interaction_areas:
            self._add_area(area)
        if self._world.vehicle_body_id >= 0:
            add_vehicle(self._stage, self._world)

    def _set_up(self) -> None:
        stage, scene = self._stage, self._world.scene
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
        root = UsdGeom.Xform.Define(stage, "/World").GetPrim()
        stage.SetDefaultPrim(root)
        Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
        describe(root, scene_facts(scene))
        start = root.CreateAttribute("aeroscene:start_position_enu_m", Sdf.ValueTypeNames.Double3)
        start.Set(Gf.Vec3d(*scene.start_position_enu_m))
        physics = UsdPhysics.Scene.Define(stage, "/World/PhysicsScene")
        physics.CreateGravityDirectionAttr(Gf.Vec3f(0.0, 0.0, -1.0))
        physics.CreateGravityMagnitudeAttr(GRAVITY_MPS2)
        for path in ("/World/Materials", "/World/Objects", "/World/Areas"):
            UsdGeom.Scope.Define(stage, path)
        sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
        sun.CreateIntensityAttr(2500.0)
        # A light shines along its -z, which a turn about x and then one about y point downwards.
        east, north, up = self._world.light.sun_direction
        about_x, about_y = math.asin(north), math.atan2(-east, -up)
        turn = Gf.Vec3f(math.degrees(about_x), math.degrees(about_y), 0.0)
        UsdGeom.XformCommonAPI(sun).SetRotate(turn)
        sky = UsdLux.DomeLight.Define(stage, "/World/Sky")
        sky.CreateIntensityAttr(700.0)
        sky.CreateColorAttr(Gf.Vec3f(0.75, 0.85, 1.0))

    def _add_ground(self) -> None:
        label(define_xform(self._stage, "/World/Ground", np.eye(4)), "ground")
        if (relief := self._world.scene.relief) is not None:
            self._add_relief(relief)
            return
        half = _GROUND_HALF_M
        corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
        surface = Surface(
            corners,
            np.tile((0.0, 0.0, 1.0), (4, 1)),
            corners[:, :2],
            np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32),
        )
        self._define_mesh("/World/Ground/look", surface, "grass")
        plane = UsdGeom.Plane.Define(self._stage, "/World/Ground/solid")
        plane.CreateAxisAttr(UsdGeom.Tokens.z)
        plane.CreatePurposeAttr(UsdGeom.Tokens.guide)  # physics only, hidden when drawn
        UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
        self._bind(plane.GetPrim(), "grass")

    def _add_relief(self, relief: Relief) -> None:
        """Add the ground of a relief, whose triangles are also its collider."""
        path, surface = "/World/Ground/look", relief_surface(relief, _GROUND_HALF_M)
        self._define_mesh(path, surface, "grass")
        prim = self._stage.GetPrimAtPath(path)
        UsdPhysics.CollisionAPI.Apply(prim)
        shape = UsdPhysics.MeshCollisionAPI.Apply(prim)
        shape.CreateApproximationAttr(UsdPhysics.Tokens.none)  # the triangles as they are, no hull

    def _add_object(self, mesh: ObjectMesh) -> None:
        obj = mesh.obj
        path = f"{self._paths[obj.parent_id]}/{object_name(obj)}"
        self._paths[obj.id] = path
        prim = define_xform(self._stage, path, mesh.pose_parent)
        label(prim, obj.category)
        describe(prim, _object_facts(obj))
        UsdGeom.Scope.Define(self._stage, f"{path}/looks")
        for material, skin in mesh.skins.items():
            self._define_mesh(f"{path}/looks/{material}", skin, material)
        if mesh.solids:
            UsdGeom.Scope.Define(self._stage, f"{path}/solids")
        # Solids are placed in the world, and a prim's pose is relative to its object.
        local = np.linalg.inv(mesh.pose_enu)
        for index, solid in enumerate(mesh.solids):
            self._add_solid(f"{path}/solids/solid_{index}", solid, local)

    def _add_neighbours(self) -> None:
        """Add the land around the site: its skins, and its solids as colliders."""
        neighbours = neighbours_of(self._world.scene)
        if not neighbours:
            return
        path = "/World/Surroundings"
        label(define_xform(self._stage, path, np.eye(4)), "surroundings")
        UsdGeom.Scope.Define(self._stage, f"{path}/looks")
        for material, skin in neighbour_skins(self._world.scene).items():
            self._define_mesh(f"{path}/looks/{material}", skin, material)
        UsdGeom.Scope.Define(self._stage, f"{path}/solids")
        for index, solid in enumerate(part for part in neighbours if part.collides):
            self._add_solid(f"{path}/solids/solid_{index}", solid, np.eye(4))

    def _define_mesh(self, path: str, surface: Surface, material: str) -> None:
        mesh = define_mesh(self._stage, path, surface.vertices_m, surface.triangles)
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(surface.normals.astype(np.float32)))
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
        )
        texture = surface.texture_m / MATERIALS[material].texture_size_m
        st.Set(Vt.Vec2fArray.FromNumpy(texture.astype(np.float32)))
        self._bind(mesh.GetPrim(), material)

    def _add_solid(self, path: str, solid: Primitive, local: Pose) -> None:
        pose = local @ pose_matrix(solid.position_enu_m, solid.quat_wxyz)
        gprim = define_solid(self._stage, path, solid)
        set_pose(gprim, pose, scale=solid.size_m if solid.kind == "box" else None)
        gprim.CreatePurposeAttr(UsdGeom.Tokens.guide)
        UsdPhysics.CollisionAPI.Apply(gprim.GetPrim())
        self._bind(gprim.GetPrim(), solid.material)

    def _add_area(self, area: InteractionArea) -> None:
        ring = np.array(area.polygon, dtype=np.float32)
        ring[:, 2] += _AREA_LIFT_M
        path = f"/World/Areas/{area_name(area)}"
        mesh = define_mesh(self._stage, path, ring, np.arange(len(ring))[None])
        mesh.CreatePurposeAttr(UsdGeom.Tokens.guide)
        mesh.CreateDisplayColorAttr([Gf.Vec3f(0.2, 0.8, 0.4)])
        label(mesh.GetPrim(), f"{area.kind}_area")
        describe(mesh.GetPrim(), area_facts(area))

    def _bind(self, prim: Usd.Prim, name: str) -> None:
        # Only the materials that occur are written, each once.
        if name not in self._materials:
            self._materials[name] = define_material(self._stage, name, self._folder)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._materials[name])


def _object_facts(obj: SceneObject) -> dict[str, Any]:
    return {
        "id": obj.id,
        "category_id": obj.category_id,
        "domain": obj.domain,
        **{f"attributes:{name}": value for name, value in obj.attributes.items()},
    }
