"""A controller of one's own: attitude and thrust 50 times a second, from the estimate alone.

PD on position and gravity give the thrust vector; its direction is the attitude. What is beneath
(rates, rotors, physics, sensors, estimator) is the plant. Run: python examples/own_controller.py
"""

import math

import numpy as np
from scipy.spatial.transform import Rotation

import flightsim
from aeroscene import ControlLevel, Plant, PlantCfg, Setpoint, Simulator, load_scene

STIFFNESS, DAMPING, UP_MPS2 = 4.0, 3.2, np.array([0.0, 0.0, 9.81])
RADIUS_M, RATE_RADPS = 2.0, 0.9


class CircleController:
    """Climbs from the start and flies circles; `Simulator` calls `update` after every 20 ms."""

    def __init__(self, plant: Plant) -> None:
        self.plant, self.start = plant, plant.estimate
        self.errors_m: list[float] = []

    def reference(self, time_s: float):
        """Position, velocity and acceleration, ENU: up at 1 m/s, round from the fifth second on."""
        w = RATE_RADPS * (time_s > 5.0)
        c, s = math.cos(w * (time_s - 5.0)), math.sin(w * (time_s - 5.0))
        offset = np.array([RADIUS_M * (c - 1.0), RADIUS_M * s, min(time_s, 4.0)])
        velocity, acceleration = w * np.array([-s, c, 0.0]), w**2 * np.array([-c, -s, 0.0])
        return self.start.position_enu_m + offset, RADIUS_M * velocity, RADIUS_M * acceleration

    def update(self) -> None:
        state, vehicle = self.plant.estimate, self.plant.world.airframe.quadrotor
        at_s = (state.time_us - self.start.time_us) * 1e-6
        position, velocity, acceleration = self.reference(at_s)
        self.errors_m.append(math.dist(position, state.position_enu_m))
        demand = acceleration + UP_MPS2 + STIFFNESS * (position - state.position_enu_m)
        demand += DAMPING * (velocity - state.velocity_enu_mps)
        thrust = vehicle.mass_kg * float(np.linalg.norm(demand)) / vehicle.max_thrust_n
        turn = Rotation.align_vectors([demand, [1, 0, 0]], [[0, 0, 1], [1, 0, 0]], [np.inf, 1])[0]
        quat = tuple(turn.as_quat(scalar_first=True).tolist())
        self.plant.apply(Setpoint(level=ControlLevel.ATTITUDE, quat_wxyz=quat, thrust=thrust))


def main() -> CircleController:
    world = flightsim.build_world(load_scene("42"), flightsim.airframe_by_name("iris"))
    plant = Plant(world, PlantCfg(seed=0))
    plant.align()
    controller = CircleController(plant)
    Simulator(plant, controller, speed="max").run(until_us=plant.time_us + 20_000_000)
    return controller


if __name__ == "__main__":
    print(f"median error {np.median(main().errors_m[300:]):.2f} m")
