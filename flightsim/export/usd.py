"""USD: the scene with physics and semantics, for Isaac Sim and other USD programs.

`/World` holds the objects in their hierarchy. Each is an Xform with its label (taxonomy `class`),
meshes under `looks` and colliders under `solids`: static, because no rigid body is above them. The
vehicle is a rigid body with the mass and the inertia of its airframe. Metres, z up.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aeroscene.scene import InteractionArea, SceneObject
from aeroscene.solids.shapes import MATERIALS, Primitive
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.export.files import ExportError, staged
from flightsim.export.glb import object_name
from flightsim.export.meshes import ObjectMesh, Pose, object_meshes, pose_matrix
from flightsim.export.usd_prims import (
    define_material,
    define_solid,
    define_xform,
    describe,
    label,
    set_pose,
)
from flightsim.export.usd_vehicle import add_vehicle
from flightsim.looks.tessellation import Surface
from flightsim.world import World

if TYPE_CHECKING:
    from pxr import Usd

_AREA_LIFT_M = 0.02
_GROUND_HALF_M = 500.0


def write_usd(world: World, folder: Path) -> Path:
    """Write `<scene>.usdc` and its textures into a folder and return the path of the stage.

    Raises:
        ExportError: If usd-core is not installed or the folder cannot be written.
    """
    try:
        from pxr import Usd  # noqa: PLC0415 - an extra
    except ImportError:
        raise ExportError(
            "to 'usd' needs usd-core, which is not installed; "
            "valid: mjcf, glb, or usd after pip install usd-core"
        ) from None
    name = f"{world.scene.scene_id}.usdc"
    with staged(folder) as stage_folder:
        stage = Usd.Stage.CreateNew(str(stage_folder / name))
        _Writer(stage, world, stage_folder).write()
        stage.GetRootLayer().Save()
        # The layer keeps the file open; another writer of the same name would find it in memory.
        del stage
    return folder / name


class _Writer:
    """Fills one stage."""

    def __init__(self, stage: Usd.Stage, world: World, folder: Path) -> None:
        self._stage = stage
        self._world = world
        self._folder = folder
        self._materials: dict[str, Any] = {}
        self._paths: dict[int | None, str] = {None: "/World/Objects"}

    def write(self) -> None:
        self._set_up()
        self._add_ground()
        for mesh in object_meshes(self._world.scene, self._world.solids):
            self._add_object(mesh)
        for area in self._world.scene.interaction_areas:
            self._add_area(area)
        if self._world.vehicle_body_id >= 0:
            add_vehicle(self._stage, self._world)

    def _set_up(self) -> None:
        from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics  # noqa: PLC0415 - an extra

        stage, scene = self._stage, self._world.scene
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
        root = UsdGeom.Xform.Define(stage, "/World").GetPrim()
        stage.SetDefaultPrim(root)
        Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
        describe(
            root,
            {
                "scene_id": scene.scene_id,
                "domain": scene.domain,
                "latitude_deg": scene.latitude_deg,
                "longitude_deg": scene.longitude_deg,
                "altitude_m": scene.altitude_m,
            },
        )
        start = root.CreateAttribute("aeroscene:start_position_enu_m", Sdf.ValueTypeNames.Double3)
        start.Set(Gf.Vec3d(*scene.start_position_enu_m))
        physics = UsdPhysics.Scene.Define(stage, "/World/PhysicsScene")
        physics.CreateGravityDirectionAttr(Gf.Vec3f(0.0, 0.0, -1.0))
        physics.CreateGravityMagnitudeAttr(GRAVITY_MPS2)
        for path in ("/World/Materials", "/World/Objects", "/World/Areas"):
            UsdGeom.Scope.Define(stage, path)
        sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
        sun.CreateIntensityAttr(2500.0)
        # A light shines along its -z; the sun is in the south-west, 57 degrees high.
        UsdGeom.XformCommonAPI(sun).SetRotate(Gf.Vec3f(28.0, -28.0, 0.0))
        sky = UsdLux.DomeLight.Define(stage, "/World/Sky")
        sky.CreateIntensityAttr(700.0)
        sky.CreateColorAttr(Gf.Vec3f(0.75, 0.85, 1.0))

    def _add_ground(self) -> None:
        from pxr import UsdGeom, UsdPhysics  # noqa: PLC0415 - an extra

        half = _GROUND_HALF_M
        corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
        surface = Surface(
            corners,
            np.tile((0.0, 0.0, 1.0), (4, 1)),
            corners[:, :2],
            np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32),
        )
        label(define_xform(self._stage, "/World/Ground", np.eye(4)), "ground")
        self._define_mesh("/World/Ground/look", surface, "grass")
        plane = UsdGeom.Plane.Define(self._stage, "/World/Ground/solid")
        plane.CreateAxisAttr(UsdGeom.Tokens.z)
        plane.CreatePurposeAttr(UsdGeom.Tokens.guide)
        UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
        self._bind(plane.GetPrim(), "grass")

    def _add_object(self, mesh: ObjectMesh) -> None:
        from pxr import UsdGeom  # noqa: PLC0415 - an extra

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
        local = np.linalg.inv(mesh.pose_enu)
        for index, solid in enumerate(mesh.solids):
            self._add_solid(f"{path}/solids/solid_{index}", solid, local)

    def _define_mesh(self, path: str, surface: Surface, material: str) -> Any:
        from pxr import Sdf, UsdGeom, Vt  # noqa: PLC0415 - an extra

        mesh = UsdGeom.Mesh.Define(self._stage, path)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(surface.vertices_m.astype(np.float32)))
        counts = np.full(len(surface.triangles), 3, dtype=np.int32)
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
        indices = surface.triangles.astype(np.int32).ravel()
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(indices))
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(surface.normals.astype(np.float32)))
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateExtentAttr(
            Vt.Vec3fArray.FromNumpy(
                np.stack([surface.vertices_m.min(0), surface.vertices_m.max(0)]).astype(np.float32)
            )
        )
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
        )
        texture = surface.texture_m / MATERIALS[material].texture_size_m
        st.Set(Vt.Vec2fArray.FromNumpy(texture.astype(np.float32)))
        self._bind(mesh.GetPrim(), material)
        return mesh

    def _add_solid(self, path: str, solid: Primitive, local: Pose) -> None:
        from pxr import UsdGeom, UsdPhysics  # noqa: PLC0415 - an extra

        pose = local @ pose_matrix(solid.position_enu_m, solid.quat_wxyz)
        gprim = define_solid(self._stage, path, solid)
        set_pose(gprim, pose, scale=solid.size_m if solid.kind == "box" else None)
        gprim.CreatePurposeAttr(UsdGeom.Tokens.guide)
        UsdPhysics.CollisionAPI.Apply(gprim.GetPrim())
        self._bind(gprim.GetPrim(), solid.material)

    def _add_area(self, area: InteractionArea) -> None:
        from pxr import Gf, UsdGeom, Vt  # noqa: PLC0415 - an extra

        path = f"/World/Areas/{area.kind}_{area.id}_{area.drone_class}"
        ring = np.array(area.polygon, dtype=np.float32)
        ring[:, 2] += _AREA_LIFT_M
        mesh = UsdGeom.Mesh.Define(self._stage, path)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(ring))
        mesh.CreateFaceVertexCountsAttr([len(ring)])
        mesh.CreateFaceVertexIndicesAttr(list(range(len(ring))))
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreatePurposeAttr(UsdGeom.Tokens.guide)
        mesh.CreateDisplayColorAttr([Gf.Vec3f(0.2, 0.8, 0.4)])
        mesh.CreateExtentAttr(
            Vt.Vec3fArray.FromNumpy(np.stack([ring.min(axis=0), ring.max(axis=0)]))
        )
        label(mesh.GetPrim(), f"{area.kind}_area")
        describe(
            mesh.GetPrim(),
            {
                "drone_class": area.drone_class,
                "radius_m": area.radius,
                "slope_rad": area.slope_rad,
                "clearance_m": area.clearance_m,
                "surface": area.surface,
                "object_id": -1 if area.object_id is None else area.object_id,
            },
        )

    def _bind(self, prim: Usd.Prim, name: str) -> None:
        from pxr import UsdShade  # noqa: PLC0415 - an extra

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
