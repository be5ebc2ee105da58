"""Landing of our pilot in the whole stack, judged by the truth."""

from __future__ import annotations

from aeroscene.scene import Scene
from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.mission.surroundings import MissionError
from scenarios.pilot import Phase
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from scenarios.trials.result import TrialResult


def fly_landing(scene: Scene, cfg: TestbenchCfg) -> tuple[TrialResult, int]:
    """Plan a mission through a scene and fly it.

    Args:
        scene: Scene.
        cfg: Settings of the testbench.

    Returns:
        The result, and the number of descents that were called off.

    Raises:
        MissionError: If the scene has no mission for the vehicle.
    """
    try:
        with Sitl(SitlCfg(demo=True, bench=cfg), scene=scene, has_network=False) as sitl:
            result = sitl.run()
            changes = () if sitl.pilot is None else sitl.pilot.transitions
    except TestbenchError as error:
        if isinstance(error.__cause__, MissionError):
            # The testbench wraps errors of the pilot that it starts.
            raise error.__cause__ from None
        raise
    # The pilot climbs again only from a descent that it gives up.
    return result, sum(change.target is Phase.CLIMB for change in changes)
