import sys

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, UsdValidation

from aeroscene.scene.box import box_corners
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.export.files import ExportError
from flightsim.export.usd import write_usd


@pytest.fixture(scope="module")
def stage(usd_path):
    return Usd.Stage.Open(str(usd_path))


@pytest.fixture(scope="module")
def prim_of(stage):
    """Prims of objects under their ids."""
    return {
        prim.GetAttribute("aeroscene:id").Get(): prim
        for prim in stage.Traverse()
        if prim.HasAttribute("aeroscene:id")
    }


def test_usds_own_validators_find_nothing(stage):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [error.GetMessage() for error in errors] == []


def test_the_stage_is_in_metres_with_z_up(stage):
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetDefaultPrim().GetPath() == "/World"
    scene = UsdPhysics.Scene.Get(stage, "/World/PhysicsScene")
    assert scene.GetGravityMagnitudeAttr().Get() == pytest.approx(GRAVITY_MPS2)


def test_the_sun_shines_as_in_pictures(world, stage):
    sun = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Sun"))
    turn = np.array(sun.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))[:3, :3]
    # USD multiplies rows; a light shines along its -z.
    np.testing.assert_allclose((0, 0, -1) @ turn, world.light.sun_direction, atol=1e-3)


def test_objects_are_nested_and_labelled(world, stage, prim_of):
    assert len(prim_of) == len(world.scene.objects)
    for obj in world.scene.objects:
        prim = prim_of[obj.id]
        labels = UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Get()
        assert list(labels) == [obj.category]
        if obj.parent_id is not None:
            assert prim.GetParent() == prim_of[obj.parent_id]


def test_colliders_fill_what_the_solids_fill(world, stage, prim_of):
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.guide])
    for object_id, prim in prim_of.items():
        solids = [s for s in world.solids if s.object_id == object_id and s.collides]
        colliders = list(prim.GetChild("solids").GetChildren())
        assert len(colliders) == len(solids)
        for solid, collider in zip(solids, colliders, strict=True):
            assert collider.HasAPI(UsdPhysics.CollisionAPI)
            box = cache.ComputeWorldBound(collider).ComputeAlignedRange()
            corners = box_corners(solid.position_enu_m, solid.quat_wxyz, solid.size_m)
            # Of an ellipsoid a polyhedron is left.
            loose_m = 0.04 * max(solid.size_m) if solid.kind == "ellipsoid" else 1e-3
            assert np.array(box.GetMin()) == pytest.approx(corners.min(axis=0), abs=loose_m)
            assert np.array(box.GetMax()) == pytest.approx(corners.max(axis=0), abs=loose_m)


def test_the_vehicle_is_a_rigid_body_of_its_mass_and_everything_else_is_static(world, stage):
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert [str(prim.GetPath()) for prim in bodies] == ["/World/Vehicle"]
    mass = UsdPhysics.MassAPI(bodies[0])
    quadrotor = world.airframe.quadrotor
    assert mass.GetMassAttr().Get() == pytest.approx(quadrotor.mass_kg)
    assert list(mass.GetDiagonalInertiaAttr().Get()) == pytest.approx(quadrotor.inertia_flu_kgm2)
    place = UsdGeom.Xformable(bodies[0]).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    assert list(place.ExtractTranslation()) == pytest.approx(world.rest_qpos[:3])


def test_textures_and_friction_are_bound(stage, usd_path):
    n_textures = 0
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh) and prim.GetParent().GetName() == "looks":
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            grip = UsdPhysics.MaterialAPI(material.GetPrim())
            assert grip.GetStaticFrictionAttr().Get() > 0.2
            texture = UsdShade.Shader.Get(stage, f"{material.GetPath()}/texture")
            if texture:
                n_textures += 1
                asset = texture.GetInput("file").Get()
                assert (usd_path.parent / asset.path).is_file()
    assert n_textures > 30


def test_areas_lie_at_their_centroids(world, stage):
    for area in world.scene.interaction_areas:
        path = f"/World/Areas/{area.kind}_{area.id}_{area.drone_class}"
        mesh = UsdGeom.Mesh.Get(stage, path)
        points = np.array(mesh.GetPointsAttr().Get())
        assert np.allclose(points, np.array(area.polygon) + (0, 0, 0.02), atol=1e-4)
        assert mesh.GetPrim().GetAttribute("aeroscene:drone_class").Get() == area.drone_class


def test_the_same_world_gives_the_same_stage(world, usd_path, tmp_path):
    again = write_usd(world, tmp_path)
    first, second = (Usd.Stage.Open(str(path)).ExportToString() for path in (usd_path, again))
    assert first.replace(str(usd_path.parent), "") == second.replace(str(tmp_path), "")


def test_without_usd_core_the_error_says_what_to_install(world, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(ExportError, match=r"pip install usd-core"):
        write_usd(world, tmp_path)
    assert list(tmp_path.iterdir()) == []
