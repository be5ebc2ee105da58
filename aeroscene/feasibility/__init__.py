"""Projection of a sampled scene to one that can be built and flown, at the least displacement.

A model samples boxes that overlap a little, float or sink. The projection moves, cuts or drops as
little as it can until every object is free and supported, and derives the landing areas.
"""

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
