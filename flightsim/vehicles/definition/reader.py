"""Reader of an airframe's TOML file.

Every field is checked against a range and against physics (inertia, balance, power to hover),
because a vehicle that cannot fly would otherwise only be noticed as a strange crash.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aeroscene.files.toml_fields import Fields
from aeroscene.files.toml_file import TomlFileError, read_toml
from aeroscene.scene import DroneClass
from autonomy.model import QuadrotorParams
from autonomy.model.layout import LayoutError, check_layout
from flightsim.vehicles.airframe import Airframe, AirframeError
from flightsim.vehicles.definition import derived_values
from flightsim.vehicles.definition.model import NamedBody, check_extent, read_mass, read_model
from flightsim.vehicles.definition.parts import (
    read_battery,
    read_cameras,
    read_gear,
    read_mesh,
)
from flightsim.vehicles.definition.rotors import RotorSet, read_rotors

_GYRATION = (0.05, 1.5)
"""Least and greatest radius of gyration over the length of the longest arm."""


def read_airframe(path: Path) -> Airframe:
    """Read the airframe in a TOML file.

    Args:
        path: The file; meshes and models are looked for beside it.

    Raises:
        AirframeError: If it cannot be read, or describes nothing that flies; the line names file,
            field and value, and what would be valid.
    """
    file = f"airframe {str(path)!r}"
    try:
        plain = read_toml(path)
    except TomlFileError as error:
        raise AirframeError(f"{file}: {error}") from None
    return _airframe(Fields(plain, file, error=AirframeError), path.parent)


def _airframe(document: Fields, folder: Path) -> Airframe:
    name, title = document.text("name", most=40), document.text("title")
    if not all(each.isalnum() or each in "-_." for each in name):
        document.fail("name", f"is {name!r}; valid: letters, digits, and - _ .")
    rotor_set, body = read_rotors(document), document.table("body")
    named = read_model(body, folder)
    quadrotor = _rigid_body(document, body, rotor_set, named)
    x, y, z = body.vector("size_m", 3, 1e-3, 5.0, "m")
    gear = read_gear(document, quadrotor)
    collision_m = derived_values.reach_m(quadrotor) + rotor_set.radius_m
    check_extent(body, named, collision_m, gear.height_m)
    airframe = Airframe(
        name=name,
        title=title,
        drone_class=_drone_class(document, quadrotor, rotor_set.radius_m),
        quadrotor=quadrotor,
        body_size_m=(x, y, z),
        leg_length_m=gear.height_m,
        leg_spread_m=gear.spread_m,
        feet_flu_m=gear.feet_flu_m,
        has_skids=gear.has_skids,
        collision_radius_m=collision_m,
        battery=read_battery(document.table("battery"), quadrotor, rotor_set.radius_m),
        cameras=read_cameras(
            document.table("cameras"),
            (x, y, z),
            gear.height_m,
            max(rotor.position_flu_m[2] for rotor in quadrotor.rotors),
        ),
        mesh=read_mesh(body, folder),
        model=None if named is None else named.model,
        **_rotor_details(rotor_set, quadrotor),
        **_thicknesses(body, quadrotor),
    )
    # Last, when every reader has named the fields that it knows.
    body.check_all_known()
    document.check_all_known()
    return airframe


def _rigid_body(
    document: Fields, body: Fields, rotor_set: RotorSet, named: NamedBody | None
) -> QuadrotorParams:
    mass_kg, (ixx, iyy, izz) = read_mass(body, named)
    quadrotor = QuadrotorParams(
        mass_kg=mass_kg,
        inertia_flu_kgm2=(ixx, iyy, izz),
        rotors=rotor_set.rotors,
    )
    # Moments of inertia m r^2, with r a share of the longest arm.
    least, most = (
        (factor * derived_values.reach_m(quadrotor)) ** 2 * quadrotor.mass_kg
        for factor in _GYRATION
    )
    for moment in (ixx, iyy, izz):
        if not least <= moment <= most:
            body.fail(
                "inertia_kgm2",
                f"is {[ixx, iyy, izz]}; valid for this mass and these arms: {least:.2g} to "
                f"{most:.2g} kg m^2",
            )
        # Triangle inequality of moments: no rigid body violates it.
        if 2.0 * moment > ixx + iyy + izz:
            body.fail(
                "inertia_kgm2",
                f"is {[ixx, iyy, izz]}, whose {moment:g} exceeds the sum of the others; valid: "
                f"up to {ixx + iyy + izz - moment:g} of a rigid body",
            )
    try:
        check_layout(quadrotor)
    except LayoutError as error:
        document.fail("rotors", f"cannot be flown: {error}")
    return quadrotor


def _drone_class(document: Fields, quadrotor: QuadrotorParams, radius_m: float) -> DroneClass:
    collision_m = derived_values.reach_m(quadrotor) + radius_m
    drone_class = derived_values.drone_class(collision_m)
    if drone_class is None:
        document.fail(
            "rotors",
            f"reach {collision_m:.3g} m from the centre of mass; valid: at most "
            f"{derived_values.largest_radius_m():.3g} m, for which large areas have room",
        )
    return drone_class


def _rotor_details(rotor_set: RotorSet, quadrotor: QuadrotorParams) -> dict[str, Any]:
    """Radius and moving parts of the rotors; defaults follow from the vehicle's mass."""
    return {
        "rotor_radius_m": rotor_set.radius_m,
        "rotor_inertia_kgm2": rotor_set.inertia_kgm2
        or derived_values.rotor_inertia_kgm2(quadrotor, rotor_set.radius_m),
        "rotor_imbalance_kgm": _given(
            rotor_set.imbalance_kgm, derived_values.rotor_imbalance_kgm(quadrotor)
        ),
        "rotor_friction_nm": _given(
            rotor_set.friction_nm, derived_values.rotor_friction_nm(quadrotor)
        ),
    }


def _thicknesses(body: Fields, quadrotor: QuadrotorParams) -> dict[str, Any]:
    """Radii of arms, legs and motors; defaults follow from the longest arm."""
    arm_m = derived_values.reach_m(quadrotor)
    return {
        name: body.number(name, 5e-4, 0.2, "m", default=share * arm_m)
        for name, share in (
            ("arm_radius_m", 0.04),
            ("leg_radius_m", 0.035),
            ("motor_radius_m", 0.07),
        )
    }


def _given(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value
