"""Planning: from a map and a goal to a trajectory that is certified before it is flown.

`plan_trajectory` plans from a state to rest at a goal, `replan` the rest of a plan around moving
obstacles, `brake` a stop. `certify` proves any trajectory, whoever made it.
"""

from autonomy.planning.braking import brake
from autonomy.planning.certificate import Certificate, certify
from autonomy.planning.craft import Craft, Method, PlannerCfg
from autonomy.planning.errors import (
    BlockedError,
    CertificateError,
    EvasionError,
    LimitsError,
    PlanningError,
    UnreachableError,
)
from autonomy.planning.field import DistanceField
from autonomy.planning.legs import plan_leg
from autonomy.planning.limits import FlightLimits
from autonomy.planning.moving_obstacles import NOTHING_MOVES, MovingObstacles
from autonomy.planning.obstacles import Obstacles, Shape
from autonomy.planning.planner import plan_trajectory
from autonomy.planning.program import prepare
from autonomy.planning.replanning import replan
from autonomy.planning.trajectory import Trajectory

__all__ = [
    "NOTHING_MOVES",
    "BlockedError",
    "Certificate",
    "CertificateError",
    "Craft",
    "DistanceField",
    "EvasionError",
    "FlightLimits",
    "LimitsError",
    "Method",
    "MovingObstacles",
    "Obstacles",
    "PlannerCfg",
    "PlanningError",
    "Shape",
    "Trajectory",
    "UnreachableError",
    "brake",
    "certify",
    "plan_leg",
    "plan_trajectory",
    "prepare",
    "replan",
]
