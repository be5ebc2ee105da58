"""Quadrotors for control tests, and a controller in perfect hover."""

import numpy as np

from autonomy.control import STATE_DTYPE, ControllerCfg, new_controller
from autonomy.model import QuadrotorParams, RotorParams

G = 9.81


def quadrotor(hubs, spins, kf=5.84e-6, c=0.06, max_speed=1100.0):
    rotors = tuple(
        RotorParams(
            position_flu_m=hub,
            spin=spin,
            thrust_constant=kf,
            torque_per_thrust_m=c,
            time_constant_up_s=0.0125,
            time_constant_down_s=0.025,
            max_speed_radps=max_speed,
            drag_coefficient=1.75e-4,
            rolling_moment_coefficient=1e-6,
        )
        for hub, spin in zip(hubs, spins, strict=True)
    )
    return QuadrotorParams(mass_kg=1.535, inertia_flu_kgm2=(0.029, 0.029, 0.055), rotors=rotors)


# notes/simulation.md: the Iris's layout is asymmetric, the Hummingbird's is a plus.
IRIS = quadrotor(
    ((0.13, -0.22, 0.023), (-0.13, 0.20, 0.023), (0.13, 0.22, 0.023), (-0.13, -0.20, 0.023)),
    (1, 1, -1, -1),
)
PLUS = quadrotor(
    ((0.17, 0.0, 0.01), (0.0, 0.17, 0.01), (-0.17, 0.0, 0.01), (0.0, -0.17, 0.01)),
    (-1, 1, -1, 1),
    kf=8.54858e-6,
    c=0.016,
    max_speed=838.0,
)


def ring(n):
    """Vehicle of the Iris's mass with n rotors around it, which spin in turn."""
    bearings = 2.0 * np.pi * (np.arange(n) + 0.5) / n
    hubs = tuple((0.25 * np.cos(b), 0.25 * np.sin(b), 0.02) for b in bearings)
    return quadrotor(hubs, tuple(1 if k % 2 else -1 for k in range(n)))


HOVER = np.sqrt(IRIS.mass_kg * G / sum(r.thrust_constant for r in IRIS.rotors))


def hovering():
    """Controller and its vehicle's state in perfect hover over the origin."""
    c = new_controller(IRIS, ControllerCfg(), dt_s=0.004)[0]
    x = np.zeros(1, STATE_DTYPE)[0]
    x["quat_wxyz"][0] = 1.0
    c["R"] = np.eye(3)
    c["rotor_model_radps"][:4] = HOVER
    return c, x
