"""A vehicle of one's own, from numbers: a heavy quadrotor of 2.4 kg with larger rotors.

Collision shape, legs and looks follow from the sizes; the controller's gains from mass, inertia and
rotors; autopilot and pilot fly it as they fly the Iris. Run: python examples/own_vehicle.py
"""

import math
from dataclasses import replace

import aeroscene

ARM_M, ROTOR_RADIUS_M, MASS_KG = 0.3, 0.165, 2.4


def rotor(bearing_deg: float, spin: int) -> aeroscene.RotorParams:
    """One of four, on an arm at this bearing from the nose, counter-clockwise."""
    bearing = math.radians(bearing_deg)
    return aeroscene.RotorParams(
        position_flu_m=(ARM_M * math.cos(bearing), ARM_M * math.sin(bearing), 0.03),
        spin=spin,
        thrust_constant=1.6e-5,
        torque_per_thrust_m=0.02,
        time_constant_up_s=0.02,
        time_constant_down_s=0.04,
        max_speed_radps=800.0,
        drag_coefficient=2e-4,
        rolling_moment_coefficient=1e-6,
    )


def heavy_quadrotor() -> aeroscene.Airframe:
    """Body, battery and cameras are the Iris's, resized."""
    iris = aeroscene.airframe_by_name("iris")
    quadrotor = aeroscene.QuadrotorParams(
        mass_kg=MASS_KG,
        inertia_flu_kgm2=(0.06, 0.06, 0.11),
        rotors=(rotor(-45, 1), rotor(135, 1), rotor(45, -1), rotor(-135, -1)),
    )
    hover_radps = math.sqrt(quadrotor.hover_thrust_fraction) * 800.0
    return replace(
        iris,
        name="heavy",
        title="Heavy quadrotor, 2.4 kg",
        quadrotor=quadrotor,
        rotor_radius_m=ROTOR_RADIUS_M,
        leg_spread_m=0.25,
        collision_radius_m=ARM_M + ROTOR_RADIUS_M,
        battery=replace(iris.battery, hover_power_w=420.0, hover_rotor_speed_radps=hover_radps),
    )


def main() -> aeroscene.TrialResult:
    cfg = aeroscene.SitlCfg(demo=True, bench=aeroscene.TestbenchCfg(speed="max"))
    with aeroscene.Sitl(cfg, airframes=[heavy_quadrotor()], has_network=False) as sitl:
        return sitl.run()


if __name__ == "__main__":
    print(main())
