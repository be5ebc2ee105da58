"""Projection of a sampled scene to one that can be flown, at the least displacement."""

from aeroscene.feasibility.projection import FeasibilityCfg, Feasible, make_feasible
from aeroscene.feasibility.report import FeasibilityReport
from aeroscene.feasibility.validity import ObjectValidity, validity

__all__ = [
    "FeasibilityCfg",
    "FeasibilityReport",
    "Feasible",
    "ObjectValidity",
    "make_feasible",
    "validity",
]
