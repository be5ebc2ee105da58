"""Contacts of vehicles: with the static world always, with movers and other vehicles on demand.

Two vehicles meet at twice the speed at which one meets a wall, and both are thin: the contact of a
vehicle with the world, soft as legs are, would let them through each other. So each vehicle among
others has a second shape for the others alone, of the same parts, as hard as the engine's step
allows and with rotors as high as their motors.
"""

from __future__ import annotations

from typing import Any

import mujoco

from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.movers import MOVER_CONTACT_BIT
from flightsim.vehicles.builder import part_name, vehicle_name

STATIC_CONTACT_BIT = 1
VEHICLE_CONTACT_BIT = 4
"""Contact bit of vehicles among each other."""
_ROTOR_HALF_HEIGHT_M = 0.03
"""Half the height that a rotor has for other vehicles: that of hub and motor."""
# Critically damped within two steps of 2 ms, the fewest that MuJoCo keeps stable, and felt from
# 3 cm on: at 20 m/s two vehicles come 4 cm nearer in a step.
_BUMPER: dict[str, Any] = {
    "contype": VEHICLE_CONTACT_BIT,
    "conaffinity": VEHICLE_CONTACT_BIT,
    "condim": 3,
    "friction": (0.5, 0.005, 0.0001),
    "solref": (0.004, 1.0),
    "solimp": (0.95, 0.99, 0.001, 0.5, 2.0),
    "margin": 0.03,
    "group": int(GeomGroup.VEHICLE_SHAPE),
    "mass": 0.0,
}


def enable_vehicle_contacts(spec: mujoco.MjSpec, n_vehicles: int) -> None:
    """Give vehicles shapes for each other, instead of those by which they touch the world.

    Args:
        spec: World with the vehicles, changed.
        n_vehicles: Number of vehicles; a single one needs no such shapes.
    """
    for number in range(n_vehicles):
        body = spec.body(vehicle_name(number))
        shapes = [geom for geom in body.geoms if geom.contype]
        for k, geom in enumerate(shapes):
            # Affinity 0: two vehicles no longer meet by these shapes, only the world's geoms still
            # do.
            geom.conaffinity = 0
            size = geom.size.copy()
            if geom.type == mujoco.mjtGeom.mjGEOM_CYLINDER:
                size[1] = max(size[1], _ROTOR_HALF_HEIGHT_M)
            body.add_geom(
                name=part_name(number, f"bumper{k}"),
                type=geom.type,
                pos=geom.pos,
                quat=geom.quat,
                size=size,
                fromto=geom.fromto,
                meshname=geom.meshname,
                **_BUMPER,
            )


def enable_mover_contacts(spec: mujoco.MjSpec, n_vehicles: int) -> None:
    """Let vehicles touch movers.

    Args:
        spec: World with the vehicles, changed.
        n_vehicles: Number of vehicles.
    """
    for number in range(n_vehicles):
        for geom in spec.body(vehicle_name(number)).geoms:
            if geom.contype & STATIC_CONTACT_BIT:
                geom.contype |= MOVER_CONTACT_BIT
