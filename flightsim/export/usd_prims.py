"""Prims of USD stages: frames, colliders, materials, labels and attributes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, Vt
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from aeroscene.scene import AttributeValue, Vector3
from aeroscene.solids.shapes import MATERIALS, Primitive
from flightsim.export.files import write_texture
from flightsim.export.meshes import EXPORT_DETAIL, Pose
from flightsim.looks.tessellation import ellipsoid

_TAXONOMY = "class"
"""Taxonomy of the labels that Isaac Sim's annotators read."""


def label(prim: Usd.Prim, name: str) -> None:
    """Give a prim its semantic label."""
    UsdSemantics.LabelsAPI.Apply(prim, _TAXONOMY).CreateLabelsAttr([name])


def describe(prim: Usd.Prim, facts: Mapping[str, AttributeValue]) -> None:
    """Attach facts as attributes `aeroscene:*`.

    Args:
        prim: Prim to describe.
        facts: Values by their names; each is a bool, an int, a float or text.
    """
    types = {
        bool: Sdf.ValueTypeNames.Bool,
        int: Sdf.ValueTypeNames.Int,
        float: Sdf.ValueTypeNames.Double,
        str: Sdf.ValueTypeNames.String,
    }
    for name, value in facts.items():
        # By the exact type: a bool is an int too.
        prim.CreateAttribute(f"aeroscene:{name}", types[type(value)]).Set(value)


def define_xform(stage: Usd.Stage, path: str, pose: Pose) -> Usd.Prim:
    """Define a frame at a pose in its parent's frame, and return its prim."""
    xform = UsdGeom.Xform.Define(stage, path)
    set_pose(xform, pose)
    return xform.GetPrim()


def set_pose(xformable: UsdGeom.Xformable, pose: Pose, scale: Vector3 | None = None) -> None:
    """Place a prim in its parent's frame by translation, orientation and scale.

    Args:
        xformable: Prim without a transform so far.
        pose: Rotation and translation.
        scale: Factors along the prim's own axes; None leaves it as large as it is.
    """
    w, x, y, z = Rotation.from_matrix(pose[:3, :3]).as_quat(scalar_first=True).tolist()
    # USD applies the last operation first: scale, then turn, then shift.
    xformable.AddTranslateOp().Set(Gf.Vec3d(*pose[:3, 3].tolist()))
    xformable.AddOrientOp().Set(Gf.Quatf(w, x, y, z))
    if scale is not None:
        xformable.AddScaleOp().Set(Gf.Vec3f(*scale))


def define_mesh(stage: Usd.Stage, path: str, points: np.ndarray, faces: np.ndarray) -> UsdGeom.Mesh:
    """Define a mesh by its points (n, 3) and the corners of its faces (f, k).

    Args:
        stage: Stage to add to.
        path: Path of the prim.
        points: Corners, (n, 3).
        faces: Numbers of each face's corners, (f, k), counter-clockwise from outside.
    """
    mesh = UsdGeom.Mesh.Define(stage, path)
    points = points.astype(np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    counts = np.full(len(faces), faces.shape[1], dtype=np.int32)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.astype(np.int32).ravel()))
    # Else a renderer would round the mesh off as a subdivision surface.
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(0), points.max(0)])))
    return mesh


def define_solid(stage: Usd.Stage, path: str, solid: Primitive) -> UsdGeom.Gprim:
    """Define a collider of a primitive's size at the origin; a box is a unit cube to be scaled.

    Args:
        stage: Stage to add to.
        path: Path of the prim.
        solid: Primitive, whose kind and size are used; its pose is not.
    """
    if solid.kind == "box":
        cube = UsdGeom.Cube.Define(stage, path)
        cube.CreateSizeAttr(1.0)
        return cube
    if solid.kind == "cylinder":
        cylinder = UsdGeom.Cylinder.Define(stage, path)
        cylinder.CreateAxisAttr(UsdGeom.Tokens.z)
        cylinder.CreateRadiusAttr(solid.size_m[0] / 2)
        cylinder.CreateHeightAttr(solid.size_m[2])
        return cylinder
    return _define_hull(stage, path, solid)


def _define_hull(stage: Usd.Stage, path: str, solid: Primitive) -> UsdGeom.Gprim:
    """Define a convex hull; engines scale no sphere unevenly, so ellipsoids are hulls too."""
    if solid.kind == "ellipsoid":
        sphere = ellipsoid(np.array(solid.size_m), EXPORT_DETAIL.slices, EXPORT_DETAIL.stacks)
        points = sphere.vertices_m
    else:
        points = np.array(solid.vertices_m)
    mesh = define_mesh(stage, path, points, ConvexHull(points).simplices)
    shape = UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim())
    shape.CreateApproximationAttr(UsdPhysics.Tokens.convexHull)
    return mesh


def define_material(stage: Usd.Stage, name: str, folder: Path) -> UsdShade.Material:
    """Define a material's look (UsdPreviewSurface, texture in a file) and its friction.

    Args:
        stage: Stage to add to.
        name: A key of `MATERIALS`.
        folder: Folder of the stage, for the texture.
    """
    look = MATERIALS[name]
    path = f"/World/Materials/{name}"
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0 - 0.7 * look.specular)
    shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    colour = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    colour.Set(Gf.Vec3f(*look.rgba[:3]))
    if look.texture:
        write_texture(folder / "textures" / f"{name}.png", look.texture, look.rgba)
        colour.ConnectToSource(_define_texture(stage, path, name))
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    # Our physics has one friction for both.
    grip = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    grip.CreateStaticFrictionAttr(look.friction)
    grip.CreateDynamicFrictionAttr(look.friction)
    grip.CreateRestitutionAttr(0.0)
    return material


def _define_texture(stage: Usd.Stage, path: str, name: str) -> Any:
    """Return the output of a texture that repeats over the mesh's coordinates `st`."""
    reader = UsdShade.Shader.Define(stage, f"{path}/coordinates")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    texture = UsdShade.Shader.Define(stage, f"{path}/texture")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"./textures/{name}.png")
    texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
    for axis in ("wrapS", "wrapT"):
        texture.CreateInput(axis, Sdf.ValueTypeNames.Token).Set("repeat")
    coordinates = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(coordinates)
    return texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
