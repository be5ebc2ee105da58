"""Drawing model of a world: a second MuJoCo model beside the one that is stepped.

Physics wants few plain solids; a picture wants textures in their true size on every face, which
MuJoCo's boxes lack. Here the static solids are dressed, lit and merged into one skin for
each paint and ground tile: some 300 meshes that draw faster than 900 geoms and are culled
well. The vehicle is the same in both models, so `qpos` of one poses the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from aeroscene.neighbourhood import neighbours_of
from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.light import AFTERNOON, Light
from flightsim.looks.mesh import MeshBuilder, WorldMesh, add_solids
from flightsim.looks.neighbours import add_neighbours
from flightsim.looks.paint import Paint
from flightsim.looks.skins import Skin, skins
from flightsim.looks.surfaces import FAST, Detail
from flightsim.looks.surroundings import add_surroundings
from flightsim.looks.textures import lit_tile, tile
from flightsim.looks.weathering import weathered

_FAR_EXTENTS = 12.0
"""Far clip plane of cameras, in multiples of half the extent's diagonal."""
LAYER_OPACITY = 0.99
"""Opacity of layers of light.

MuJoCo draws what is less opaque than 0.995 after everything else, twice, and without depth. After
two times all but a ten-thousandth of the colour below is gone, which is no step of an image.
"""


def set_view(spec: mujoco.MjSpec, scene: Scene, light: Light = AFTERNOON) -> None:
    """Set clip planes, light and sky, the same in both models.

    Args:
        spec: Model, changed.
        scene: Its scene, whose extent sets the clip planes.
        light: Sun and sky.
    """
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    spec.stat.center = (low + high) / 2
    spec.stat.extent = _half_diagonal_m(scene)
    visual: Any = spec.visual
    # MuJoCo multiplies both clip planes by the extent: 3 cm and 12 extents.
    visual.map.znear = 0.03 / spec.stat.extent
    visual.map.zfar = _FAR_EXTENTS
    # No multisampling, few sides and bands: software rendering at camera rate affords no more.
    visual.quality.offsamples = 0
    visual.quality.numslices = FAST.slices
    visual.quality.numstacks = FAST.stacks
    visual.quality.numquads = 1
    # No OpenGL shadows: a shadow map costs start-up time.
    visual.quality.shadowsize = 0
    visual.headlight.ambient = light.ambient_rgb
    visual.headlight.diffuse = (0.0, 0.0, 0.0)
    visual.headlight.specular = (0.0, 0.0, 0.0)
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(0.0, 0.0, 100.0),
        dir=light.sun_direction,
        diffuse=light.sun_rgb,
        specular=(0.15, 0.15, 0.15),
        ambient=(0.0, 0.0, 0.0),
        castshadow=True,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=light.sky.zenith_rgb,
        rgb2=light.sky.horizon_rgb,
        width=128,
        height=768,
    )


def add_looks(
    spec: mujoco.MjSpec,
    scene: Scene,
    primitives: Sequence[Primitive],
    detail: Detail,
    light: Light = AFTERNOON,
) -> None:
    """Add the skins of the ground and of static solids to the world body.

    Args:
        spec: Model to add to.
        scene: Scene of the solids, with their categories and the ground.
        primitives: Solids to draw.
        detail: Detail of round shapes, and light and textures of the skins.
        light: Sun, sky, season and weather.
    """
    mesh, layers = drawn_mesh(scene, primitives, detail, light), None
    if detail.has_light:
        # Imported here, because polygons and rays load only when someone draws.
        from flightsim.looks.bake import lit

        whole = lit(mesh, (*primitives, *neighbours_of(scene)), scene.relief, light)
        mesh, layers = whole.surfaces, whole.layers
    materials: dict[Paint, str] = {}
    # Skins of surfaces come first and without the layers, whose number varies with the light:
    # another division into skins would round depth differently.
    for index, skin in enumerate(skins(mesh)):
        if skin.paint not in materials:
            materials[skin.paint] = f"paint{len(materials)}"
            _add_material(spec, materials[skin.paint], skin.paint, detail, light)
        _add_skin(spec, f"skin{index}", skin, materials[skin.paint], GeomGroup.SCENE)
    of_layers: dict[Paint, str] = {}
    for index, skin in enumerate(skins(layers) if layers is not None else ()):
        if skin.paint not in of_layers:
            of_layers[skin.paint] = f"{materials[skin.paint]}_layer"
            _add_layer_material(spec, of_layers[skin.paint], materials[skin.paint])
        _add_skin(spec, f"layer{index}", skin, of_layers[skin.paint], GeomGroup.DECOR)


def drawn_mesh(
    scene: Scene, primitives: Sequence[Primitive], detail: Detail, light: Light = AFTERNOON
) -> WorldMesh:
    """Return all static surfaces that a camera sees, with true normals.

    Args:
        scene: The scene, with its ground and what lies around it.
        primitives: Its solids.
        detail: Detail of round shapes.
        light: Light whose season and weather change the paints.
    """
    builder = MeshBuilder(scene.relief)
    add_surroundings(builder, scene, _FAR_EXTENTS * _half_diagonal_m(scene))
    categories = {obj.id: obj.category for obj in scene.objects}
    add_solids(builder, primitives, categories, detail)
    add_neighbours(builder, neighbours_of(scene))
    mesh = builder.mesh()
    return replace(mesh, paints=tuple(weathered(paint, light) for paint in mesh.paints))


def _half_diagonal_m(scene: Scene) -> float:
    span = np.array(scene.extent_max_enu_m) - np.array(scene.extent_min_enu_m)
    return float(np.linalg.norm(span)) / 2


def _add_material(
    spec: mujoco.MjSpec, name: str, paint: Paint, detail: Detail, light: Light
) -> None:
    # Highlights need true normals, which lit skins lack.
    surface = spec.add_material(name=name, rgba=(*paint.rgb, 1.0), specular=0.0, reflectance=0.0)
    if paint.texture is None or not detail.has_textures:
        return
    if paint.is_lit_within:
        picture = lit_tile(paint.texture, paint.rgb, light.wall_rgb)
        # The picture has its own light: full emission keeps the lamps outside from adding to it.
        surface.emission = 1.0
    else:
        picture = tile(paint.texture, paint.rgb)
    texture = spec.add_texture(
        name=name,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        width=picture.shape[1],
        height=picture.shape[0],
        nchannel=3,
    )
    texture.data = picture.tobytes()
    surface.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    # The texture carries the colour.
    surface.rgba = (1.0, 1.0, 1.0, 1.0)


def _add_layer_material(spec: mujoco.MjSpec, name: str, surface: str) -> None:
    """Add the material of layers that lie on surfaces of another material."""
    below = spec.material(surface)
    red, green, blue, _ = below.rgba
    layer = spec.add_material(
        name=name,
        rgba=(red, green, blue, LAYER_OPACITY),
        specular=0.0,
        reflectance=0.0,
        emission=below.emission,
    )
    layer.textures = below.textures


def _add_skin(spec: mujoco.MjSpec, name: str, skin: Skin, material: str, group: GeomGroup) -> None:
    faces = skin.triangles.astype(np.int32).ravel()
    spec.add_mesh(
        name=name,
        uservert=skin.vertices_enu_m.ravel(),
        usernormal=skin.normals.ravel(),
        # MuJoCo's v grows downwards.
        usertexcoord=(skin.texture_tiles * (1.0, -1.0)).ravel(),
        userface=faces,
        userfacenormal=faces,
        userfacetexcoord=faces,
        # A skin need not enclose a volume.
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        material=material,
        contype=0,
        conaffinity=0,
        group=int(group),
    )
