"""Landing of our pilot in the whole stack, judged by the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aeroscene.scene import Scene
from flightsim.mavlink.client.client import MavlinkClient
from flightsim.sensors.cameras import Cameras, depth_noise
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.mission.mission import plan_mission
from scenarios.pilot import Phase, Pilot, PilotCfg
from scenarios.run.scoring import score_flight
from scenarios.run.trial import MAX_TRIAL_S, SETTLE_S, judge

_ALOFT_M = 0.2
"""Height above the resting place that is clear of the surface."""
_BEFORE_S = 0.02


@dataclass(frozen=True, kw_only=True, slots=True)
class Landing:
    """Result of one flight."""

    is_success: bool
    reason: str
    touchdown_error_m: float | None
    """Horizontal distance of the resting place from the chosen point."""
    touchdown_speed_mps: float
    """Fastest descent in the 20 ms before touching."""
    tilt_at_rest_deg: float
    n_aborts: int
    """Number of aborted descents."""


def fly_landing(scene: Scene, cfg: TestbenchCfg) -> Landing:
    """Plan a mission through a scene and fly it.

    Raises:
        MissionError: If the scene has no mission for the vehicle.
    """
    history: list[np.ndarray] = []
    with Testbench(scene, cfg, has_network=False) as bench:
        plant, leg_m = bench.plant, bench.airframe.leg_length_m
        mission = plan_mission(scene, bench.airframe, seed=cfg.seed)
        noise = depth_noise(cfg.depth_camera, cfg.seed)
        with Cameras(plant, depth_noise=noise) as cameras:
            client = MavlinkClient(bench.pilot_link.client, bench.frame)
            pilot_cfg = PilotCfg(expects_traffic=cfg.traffic_cfg.has_any)
            pilot = Pilot(client, mission, cameras.render, pilot_cfg)
            bench.observers.append(lambda: history.append(plant.history.copy()))
            bench.observers.append(lambda: pilot.update(plant.time_us))
            run = bench.simulator.run
            run(until_us=round(MAX_TRIAL_S * 1e6), stop=lambda: pilot.is_done)
            run(until_us=plant.time_us + round(SETTLE_S * 1e6))
    flown = np.concatenate(history)
    score = score_flight(flown, pilot.area, pilot.touchdown_enu_m, leg_m)
    verdict = judge(pilot, score)
    return Landing(
        is_success=verdict.success,
        reason=verdict.reason,
        touchdown_error_m=score.touchdown_error_m,
        touchdown_speed_mps=touchdown_speed_mps(flown),
        tilt_at_rest_deg=score.tilt_at_rest_deg,
        n_aborts=sum(change.target is Phase.CLIMB for change in pilot.transitions),
    )


def touchdown_speed_mps(history: np.ndarray) -> float:
    """Speed of descent just before the last touchdown; 0 if the vehicle never rose."""
    height_m = history["position_true_enu_m"][:, 2]
    aloft = np.flatnonzero(height_m > height_m[-1] + _ALOFT_M)
    if not aloft.size:
        return 0.0
    after = aloft[-1] + np.flatnonzero(history["is_touching"][aloft[-1] :] > 0)
    if not after.size:
        return 0.0
    tick_s = (history["time_us"][1] - history["time_us"][0]) * 1e-6
    before = max(after[0] - round(_BEFORE_S / tick_s), 0)
    return float(-history["velocity_true_enu_mps"][before : after[0], 2].min())
