"""Body of an airframe in a file of its own: its shapes, and its mass if it states one."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from aeroscene.files.toml_fields import Fields
from autonomy.types import Vector3
from flightsim.vehicles.airframe import BodyModel
from flightsim.vehicles.body_file import (
    SUFFIXES,
    BodyFile,
    BodyFileError,
    BodyMass,
    read_body_file,
)

_LEAST_KG, _MOST_KG = 0.005, 200.0
_FARTHEST_M = 5.0
_OFF_CENTRE_M = 0.005
"""Greatest distance of the file's centre of mass from the vehicle's."""
_MISFIT = 0.02
"""Greatest relative difference of a mass or a moment of inertia between the two files."""
_PRODUCT = 0.05
"""Greatest product of inertia over the least moment."""


class NamedBody(NamedTuple):
    """A body in a file of its own: how the vehicle uses it, and its content."""

    model: BodyModel
    content: BodyFile


def read_model(body: Fields, folder: Path) -> NamedBody | None:
    """Read `[body.model]`, whose file is looked for beside the airframe's.

    Args:
        body: Table `[body]`.
        folder: Folder of the airframe's file.

    Returns:
        None if there is no such table.

    Raises:
        AirframeError: Naming the first field that is wrong.
    """
    if not body.has("model"):
        return None
    if body.has("mesh"):
        body.fail("model", "stands beside mesh; valid: one of the two")
    table = body.table("model")
    path = (folder / table.text("file", most=400)).resolve()
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        valid = " or ".join(SUFFIXES)
        table.fail("file", f"is {str(path)!r}; valid: an existing file, {valid}")
    try:
        content = read_body_file(path)
    except BodyFileError as error:
        table.fail("file", f"is {str(path)!r}: {error}")
    hits_things = table.flag("hits_things", default=False)
    if hits_things and not content.solids:
        table.fail(
            "hits_things", f"is true, but nothing in {path.name} touches things; valid: false"
        )
    model = BodyModel(
        path=str(path), position_flu_m=_position(table, content.mass), hits_things=hits_things
    )
    table.check_all_known()
    return NamedBody(model, content)


def _position(table: Fields, mass: BodyMass | None) -> Vector3:
    """Place of the file's origin: by default its centre of mass becomes the vehicle's."""
    # The file's origin lies opposite to its centre of mass, which then is the vehicle's.
    fitting_m = np.zeros(3) if mass is None else -mass.centre_m
    x, y, z = table.vector(
        "position_m", 3, -_FARTHEST_M, _FARTHEST_M, "m", default=tuple(fitting_m.tolist())
    )
    if mass is not None and math.dist((x, y, z), fitting_m) > _OFF_CENTRE_M:
        table.fail(
            "position_m",
            f"is {[x, y, z]}, which puts the file's centre of mass beside the vehicle's; valid: "
            f"{np.round(fitting_m, 4).tolist()}",
        )
    return (x, y, z)


def read_mass(body: Fields, named: NamedBody | None) -> tuple[float, Vector3]:
    """Return mass in kg and moments of inertia in kg m^2 about x, y, z, of `[body]` or of its file.

    Args:
        body: Table `[body]`.
        named: The body of its file.

    Raises:
        AirframeError: If neither states them, both do and differ, or they are no vehicle's.
    """
    mass = None if named is None else named.content.mass
    if mass is None or body.has("mass_kg"):
        mass_kg = body.number("mass_kg", _LEAST_KG, _MOST_KG, "kg")
    else:
        mass_kg = mass.mass_kg
        if not _LEAST_KG <= mass_kg <= _MOST_KG:
            valid = f"{_LEAST_KG:g} to {_MOST_KG:g} kg"
            body.fail("model", f"has a file with a mass of {mass_kg:g} kg; valid: {valid}")
    moments = None if mass is None else _moments(body, mass)
    if moments is None or body.has("inertia_kgm2"):
        ixx, iyy, izz = body.vector("inertia_kgm2", 3, 1e-9, 1e3, "kg m^2")
    else:
        ixx, iyy, izz = moments
    if mass is not None and moments is not None:
        _check_same(body, "mass_kg", [mass_kg], [mass.mass_kg])
        # Both may be stated if they agree, so a file can be exchanged without a silent change.
        _check_same(body, "inertia_kgm2", [ixx, iyy, izz], moments)
    return mass_kg, (ixx, iyy, izz)


def _moments(body: Fields, mass: BodyMass) -> list[float]:
    moments = np.diag(mass.inertia_kgm2)
    products = mass.inertia_kgm2 - np.diag(moments)
    # The dynamics knows principal moments only: larger products would fly wrongly.
    if np.abs(products).max() > _PRODUCT * moments.min():
        body.fail(
            "model",
            f"has a file with a product of inertia of {np.abs(products).max():.3g} kg m^2; valid: "
            f"up to {_PRODUCT * moments.min():.2g}, principal axes forward, left and up",
        )
    return moments.tolist()


def _check_same(body: Fields, field: str, own: list[float], files: list[float]) -> None:
    if not np.allclose(own, files, rtol=_MISFIT, atol=0.0):
        said = [float(f"{value:.4g}") for value in files]
        body.fail(
            field,
            f"is {own if len(own) > 1 else own[0]:}, but the file of model says "
            f"{said if len(said) > 1 else said[0]}; valid: that, or no {field}",
        )


def check_extent(body: Fields, named: NamedBody | None, radius_m: float, height_m: float) -> None:
    """Refuse a file whose solid parts reach beyond the vehicle's assumed extents.

    Clearances, areas and planners use those extents, so a longer part would hit what they call
    free.

    Args:
        body: Table `[body]`.
        named: The body of its file.
        radius_m: Radius of the upright cylinder around the vehicle.
        height_m: Height of the centre of mass above the soles.

    Raises:
        AirframeError: If they do.
    """
    if named is None or not named.model.hits_things:
        # A body that is only drawn may be of any size.
        return
    for part in named.content.solids:
        corners_m = part.corners_m + named.model.position_flu_m
        reach_m, low_m = np.hypot(*corners_m.T[:2]).max(), corners_m[:, 2].min()
        # A part at the soles' height would stand on the ground instead of the legs.
        if reach_m > radius_m or low_m <= -height_m:
            body.fail(
                "model",
                # Without MuJoCo's prefix mjGEOM_.
                f"has a solid {part.shape.name[7:].lower()} that reaches {reach_m:.3g} m aside and "
                f"{-low_m:.3g} m down; valid: {radius_m:.3g} m, the rotors' tips, and less than "
                f"{height_m:.3g} m, the soles",
            )
