"""Planning: from a map and a goal to a trajectory that is proved safe before it is flown."""

from autonomy.planning.certificate import Certificate, certify
from autonomy.planning.errors import (
    BlockedError,
    CertificateError,
    LimitsError,
    PlanningError,
    UnreachableError,
)
from autonomy.planning.field import DistanceField
from autonomy.planning.limits import FlightLimits
from autonomy.planning.obstacles import Obstacles, Shape
from autonomy.planning.planner import PlannerCfg, plan_leg, plan_trajectory
from autonomy.planning.trajectory import Trajectory

__all__ = [
    "BlockedError",
    "Certificate",
    "CertificateError",
    "DistanceField",
    "FlightLimits",
    "LimitsError",
    "Obstacles",
    "PlannerCfg",
    "PlanningError",
    "Shape",
    "Trajectory",
    "UnreachableError",
    "certify",
    "plan_leg",
    "plan_trajectory",
]
