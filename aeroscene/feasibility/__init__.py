"""From a scene that was sampled to one that can be flown, at the least displacement."""

from aeroscene.feasibility.projection import FeasibilityCfg, Feasible, make_feasible
from aeroscene.feasibility.report import Displacement, FeasibilityReport, StageReport
from aeroscene.feasibility.validity import ObjectValidity, validity

__all__ = [
    "Displacement",
    "FeasibilityCfg",
    "FeasibilityReport",
    "Feasible",
    "ObjectValidity",
    "StageReport",
    "make_feasible",
    "validity",
]
