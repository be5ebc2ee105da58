"""The scene `field`: open, flat and without obstacles, for flights that need only space."""

from __future__ import annotations

from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneObject, Vector3
from aeroscene.scene.catalogue import by_name
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

FIELD_NAME = "field"
HILLS_NAME = "hills"
"""Name of the scene of `aeroscene.corpus.hills`."""
_HALF_M, _CEILING_M = 100.0, 60.0
_LAWN_M: Vector3 = (60.0, 60.0, 0.1)
_PAD_M: Vector3 = (2.6, 2.6, 0.06)
_TARGET_ENU_M = (18.0, 12.0)
"""Centre of the pad to land on; the pad to start from is at the origin."""


def field_scene() -> Scene:
    """A lawn in an open plain, with a pad to start from and one to land on; always the same."""
    lawn_m = _LAWN_M[2]
    return Scene(
        scene_id=FIELD_NAME,
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-_HALF_M, -_HALF_M, 0.0),
        extent_max_enu_m=(_HALF_M, _HALF_M, _CEILING_M),
        start_position_enu_m=(0.0, 0.0, lawn_m + _PAD_M[2]),
        start_yaw_rad=0.0,
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=(
            _upright(0, "lawn", (0.0, 0.0, 0.0), _LAWN_M),
            _upright(1, "landing_pad", (0.0, 0.0, lawn_m), _PAD_M, is_start=True),
            _upright(2, "landing_pad", (*_TARGET_ENU_M, lawn_m), _PAD_M),
        ),
        interaction_areas=(_area_on_target(lawn_m + _PAD_M[2]),),
    )


def _upright(
    number: int, category: str, foot_enu_m: Vector3, size_m: Vector3, **attributes: bool
) -> SceneObject:
    """An upright box, given by the middle of its lower face."""
    x, y, z = foot_enu_m
    return SceneObject(
        id=number,
        scene_id=FIELD_NAME,
        parent_id=0 if number else None,
        category_id=by_name()[category].id,
        bbox=OrientedBox(p=(x, y, round(z + size_m[2] / 2, 4)), q=(1.0, 0.0, 0.0, 0.0), s=size_m),
        domain="outdoor",
        attributes=attributes,
    )


def _area_on_target(top_m: float) -> InteractionArea:
    """The whole upper face of the pad to land on."""
    (x, y), half_m = _TARGET_ENU_M, _PAD_M[0] / 2
    # Counter-clockwise from above, as the schema asks for.
    corners = ((-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m))
    return InteractionArea(
        id=0,
        kind="landing",
        object_id=2,
        polygon=tuple((x + u, y + v, top_m) for u, v in corners),
        centroid=(x, y, top_m),
        radius=half_m,
        drone_class="medium",
        slope_rad=0.0,
        clearance_m=_CEILING_M - top_m,
        surface=by_name()["landing_pad"].surface,
    )
