"""Perception: from depth images to a place where the vehicle can stand."""

from autonomy.perception.elevation import DepthImage, ElevationMap
from autonomy.perception.landing import LandingMap, LandingNeeds, LandingSite, assess, choose_site

__all__ = [
    "DepthImage",
    "ElevationMap",
    "LandingMap",
    "LandingNeeds",
    "LandingSite",
    "assess",
    "choose_site",
]
