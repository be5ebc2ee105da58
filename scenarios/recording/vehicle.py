"""The vehicle in a recording: a simple model in its body frame, and the mounts of its cameras."""

from __future__ import annotations

import numpy as np
import rerun as rr
from jaxtyping import Float

from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.builder import leg_axes_flu_m, skid_axes_flu_m
from scenarios.recording import layout
from scenarios.recording.entity_stream import EntityStream

_BODY_RGB = (45, 48, 55)
_ARM_RGB = (70, 74, 82)
_MARKER_RGB = (255, 60, 60)
_FRONT_RGBA = (255, 120, 40, 150)
_REAR_RGBA = (70, 160, 255, 150)


def log_vehicle(stream: EntityStream, airframe: Airframe) -> None:
    """Write fuselage, arms, rotor discs, legs and camera mounts.

    The pose comes with the flight, so everything is written once, in body FLU.

    Args:
        stream: Stream of the vehicle.
        airframe: Vehicle to draw.
    """
    hubs = np.array([r.position_flu_m for r in airframe.quadrotor.rotors])
    body = rr.Boxes3D(sizes=[airframe.body_size_m], colors=[_BODY_RGB], fill_mode="solid")
    stream.log(layout.FUSELAGE, body, static=True)
    discs = rr.Cylinders3D(
        centers=hubs,
        radii=airframe.rotor_radius_m,
        lengths=0.01,
        # Two colours show where the front is; rotors amidships count as rear ones.
        colors=[_FRONT_RGBA if x > 1e-3 else _REAR_RGBA for x in hubs[:, 0]],
        fill_mode="solid",
    )
    stream.log(layout.ROTORS, discs, static=True)
    strips, radii_m = _frame_strips(airframe, hubs)
    bars = rr.LineStrips3D(strips, colors=[_ARM_RGB], radii=radii_m)
    stream.log(layout.FRAME, bars, static=True)
    # A dot of constant size on the screen, because the vehicle is small in a whole scene.
    marker = rr.Points3D([(0.0, 0.0, 0.0)], colors=_MARKER_RGB, radii=rr.Radius.ui_points(3.0))
    stream.log(layout.MARKER, marker, static=True)
    # Cameras that only look for traffic too, because a pilot that expects traffic renders them.
    for mount in airframe.cameras:
        turn = mount.rotation_flu_from_optical
        pose = rr.Transform3D(translation=mount.position_flu_m, mat3x3=turn)
        stream.log(layout.camera(mount.name), pose, static=True)


def _frame_strips(
    airframe: Airframe, hubs: Float[np.ndarray, "n 3"]
) -> tuple[list[np.ndarray], list[float]]:
    """Return axes and radii of the arms and the landing gear, as collisions see them."""
    arms = [np.array([(0.0, 0.0, 0.0), (x, y, 0.0)]) for x, y, _ in hubs]
    axes = (*leg_axes_flu_m(airframe), *skid_axes_flu_m(airframe))
    legs = [np.array(ends) for ends in axes]
    radii_m = [airframe.arm_radius_m] * len(arms) + [airframe.leg_radius_m] * len(legs)
    return [*arms, *legs], radii_m
