"""Landing gear, battery, cameras and mesh of an airframe's file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from shapely import MultiPoint, Point, Polygon

from aeroscene.files.toml_fields import Fields
from autonomy.model import QuadrotorParams
from autonomy.types import Vector3
from flightsim.vehicles.airframe import BatteryParams, BodyMesh, CameraMount
from flightsim.vehicles.definition import derived_values
from flightsim.vehicles.mesh_file import SUFFIXES, MeshFileError, check_mesh

_SPARE_POWER = 1.3
"""Least power of a battery over the power of hovering."""
_CELL_V = 3.7  # nominal voltage of a cell
_FARTHEST_M = 5.0
_MAST_M = 0.04
"""Height above the rotors of the cameras that look up: rotors would cover the view."""
_STEADY = 0.3
"""Least distance of the centre of mass from the edge of the feet, over its height."""


class Gear(NamedTuple):
    """Landing gear: height and spread of the soles, and their places."""

    height_m: float
    spread_m: float
    feet_flu_m: tuple[tuple[float, float], ...]
    has_skids: bool


def read_gear(document: Fields, quadrotor: QuadrotorParams) -> Gear:
    """Read `[legs]` or `[skids]`.

    Args:
        document: The whole file.
        quadrotor: Rotors, under whose arms legs stand by default.

    Raises:
        AirframeError: Naming the first field that is wrong.
    """
    if document.has("skids"):
        if document.has("legs"):
            document.fail("skids", "stands beside legs; valid: one of the two")
        return _skids(document.table("skids"))
    legs = document.table("legs")
    height_m = legs.number("length_m", 0.003, 2.0, "m")
    if not legs.has("feet_m"):
        spread_m = legs.number("spread_m", 0.005, _FARTHEST_M, "m")
        legs.check_all_known()
        # Without places of its own a leg stands below each arm.
        bearings = [math.atan2(r.position_flu_m[1], r.position_flu_m[0]) for r in quadrotor.rotors]
        feet = [(spread_m * math.cos(b), spread_m * math.sin(b)) for b in bearings]
        _check_steady(legs, "spread_m", feet, height_m)
        return Gear(height_m, spread_m, (), has_skids=False)
    if legs.has("spread_m"):
        legs.fail("feet_m", "stands beside spread_m; valid: one of the two")
    feet = [(x, y) for x, y in legs.rows("feet_m", 2, (3, 16), -_FARTHEST_M, _FARTHEST_M, "m")]
    legs.check_all_known()
    _check_steady(legs, "feet_m", feet, height_m)
    return Gear(height_m, max(math.hypot(*foot) for foot in feet), tuple(feet), has_skids=False)


def _skids(skids: Fields) -> Gear:
    height_m = skids.number("height_m", 0.003, 2.0, "m")
    length_m = skids.number("length_m", 0.01, _FARTHEST_M, "m")
    spacing_m = skids.number("spacing_m", 0.01, _FARTHEST_M, "m")
    skids.check_all_known()
    # A skid bears at its two ends.
    x, y = length_m / 2, spacing_m / 2
    feet = ((x, y), (-x, y), (x, -y), (-x, -y))
    _check_steady(skids, "spacing_m", feet, height_m)
    return Gear(height_m, math.hypot(x, y), feet, has_skids=True)


def _check_steady(
    table: Fields,
    field: str,
    feet: tuple[tuple[float, float], ...] | list[tuple[float, float]],
    height_m: float,
) -> None:
    """Refuse feet over which the centre of mass would tip.

    Raises:
        AirframeError: If it would.
    """
    # Feet in one line have no area, and their hull is no polygon.
    ground, centre = MultiPoint(feet).convex_hull, Point(0.0, 0.0)
    inside_m = ground.exterior.distance(centre) if isinstance(ground, Polygon) else 0.0
    if not ground.contains(centre) or inside_m < _STEADY * height_m:
        table.fail(
            field,
            f"leaves the centre of mass {inside_m if ground.contains(centre) else 0.0:.3g} m "
            f"within the feet; valid: at least {_STEADY * height_m:.3g} m, {_STEADY:g} of its "
            "height",
        )


def read_battery(table: Fields, quadrotor: QuadrotorParams, radius_m: float) -> BatteryParams:
    """Read `[battery]`, and check that it can carry the vehicle.

    Args:
        table: Table `[battery]`.
        quadrotor: Mass and rotors.
        radius_m: Radius of a rotor.

    Raises:
        AirframeError: Naming the first field that is wrong.
    """
    efficiency = table.number(
        "propulsive_efficiency", 0.02, 0.9, default=derived_values.PROPULSIVE_EFFICIENCY
    )
    params = BatteryParams(
        cells=table.count("cells", 1, 24),
        capacity_mah=table.number("capacity_mah", 10.0, 2e5, "mAh"),
        internal_resistance_ohm=table.number("internal_resistance_ohm", 1e-4, 5.0, "ohm"),
        hover_power_w=derived_values.hover_power_w(quadrotor, radius_m, efficiency),
        hover_rotor_speed_radps=quadrotor.hover_speed_radps,
        avionics_power_w=table.number("avionics_power_w", 0.0, 1e3, "W"),
        n_rotors=len(quadrotor.rotors),
    )
    needed_w = _SPARE_POWER * (params.hover_power_w + params.avionics_power_w)
    open_v = _CELL_V * params.cells
    # E^2 / 4R is the greatest power that a source of voltage E and resistance R delivers.
    if open_v**2 / (4.0 * params.internal_resistance_ohm) < needed_w:
        table.fail(
            "internal_resistance_ohm",
            f"is {params.internal_resistance_ohm:g}, which leaves too little power of "
            f"{params.cells} cells for hovering at {params.hover_power_w:.3g} W; valid: up to "
            f"{open_v**2 / (4.0 * needed_w):.2g} ohm",
        )
    table.check_all_known()
    return params


def read_cameras(
    table: Fields, size_m: Vector3, height_m: float, rotors_m: float
) -> tuple[CameraMount, ...]:
    """Read the cameras, one a table; defaults follow from the body.

    Args:
        table: Table with the tables `forward`, `down`, `up_left`, `up_right` and `up_rear`.
        size_m: Full extents of the body.
        height_m: Height of the centre of mass above the soles.
        rotors_m: Height of the highest rotor above the centre of mass.

    Raises:
        AirframeError: Naming the first field that is wrong.
    """
    length_m, _, thickness_m = size_m
    # Just ahead of the nose, so the body is out of view.
    ahead_m = (0.6 * length_m, 0.0, 0.0)
    below_m = (0.2 * length_m, 0.0, -min(0.65 * thickness_m, 0.8 * height_m))
    above_m = (0.0, 0.0, max(thickness_m / 2, rotors_m) + _MAST_M)
    mounts = (
        _camera(table.table("forward"), "forward", ahead_m, 15.0, height_m),
        _camera(table.table("down"), "down", below_m, 90.0, height_m),
        # The pilot sees upwards by these three wide views; they have depth alone.
        *(
            _camera(table.table(name), name, above_m, pitch, height_m, fov_deg=107.0, yaw_deg=yaw)
            for name, pitch, yaw in (
                ("up_left", -40.0, 66.0),
                ("up_right", -40.0, -66.0),
                ("up_rear", -30.0, 180.0),
            )
        ),
    )
    table.check_all_known()
    return mounts


def _camera(
    table: Fields,
    name: str,
    position_m: Vector3,
    pitch_deg: float,
    height_m: float,
    fov_deg: float = 60.0,
    yaw_deg: float = 0.0,
) -> CameraMount:
    position = table.vector("position_m", 3, -_FARTHEST_M, _FARTHEST_M, "m", default=position_m)
    if position[2] <= -height_m:
        table.fail("position_m", f"is {list(position)}; valid: above the ground, z > {-height_m:g}")
    mount = CameraMount(
        name=name,
        position_flu_m=(position[0], position[1], position[2]),
        pitch_down_rad=math.radians(
            table.number("pitch_down_deg", -90.0, 90.0, "degrees", default=pitch_deg)
        ),
        vertical_fov_rad=math.radians(
            table.number("vertical_fov_deg", 10.0, 120.0, "degrees", default=fov_deg)
        ),
        yaw_rad=math.radians(table.number("yaw_deg", -180.0, 180.0, "degrees", default=yaw_deg)),
        has_colour=name in {"forward", "down"},
    )
    table.check_all_known()
    return mount


def read_mesh(body: Fields, folder: Path) -> BodyMesh | None:
    """Read `[body.mesh]`, whose file is looked for beside the airframe's.

    Args:
        body: Table `[body]`.
        folder: Folder of the airframe's file.

    Returns:
        None if there is no such table.

    Raises:
        AirframeError: Naming the first field that is wrong.
    """
    if not body.has("mesh"):
        return None
    table = body.table("mesh")
    path = (folder / table.text("file", most=400)).resolve()
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        valid = " or ".join(SUFFIXES)
        table.fail("file", f"is {str(path)!r}; valid: an existing file, {valid}")
    x, y, z = table.vector("position_m", 3, -5.0, 5.0, "m", default=(0.0, 0.0, 0.0))
    mesh = BodyMesh(
        path=str(path),
        scale=table.number("scale", 1e-6, 1e3, "m", default=1.0),
        position_flu_m=(x, y, z),
    )
    try:
        check_mesh(mesh.path, mesh.scale)
    except MeshFileError as error:
        table.fail("file", f"is {str(path)!r}: {error}")
    table.check_all_known()
    return mesh
