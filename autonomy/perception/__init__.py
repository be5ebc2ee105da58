"""Perception: from depth images to landing sites, moving obstacles and the place in a map.

Three uses share `DepthImage`: `assess` and `choose_site` judge ground to land on, `MoverTracker`
follows moving obstacles, and `MapAnchor` ties the estimate to a map.
"""

from autonomy.perception.anchor_fix import AnchorFix
from autonomy.perception.camera_pose import camera_pose
from autonomy.perception.depth_image import DepthImage
from autonomy.perception.elevation import ElevationMap
from autonomy.perception.landing import (
    LandingMap,
    LandingSite,
    assess,
    choose_site,
    objection,
    site_at,
)
from autonomy.perception.map_anchor import MapAnchor
from autonomy.perception.map_anchor_cfg import MapAnchorCfg
from autonomy.perception.map_match import MapMatcher
from autonomy.perception.mover_tracker import MoverTracker, MoverTrackerCfg
from autonomy.perception.needs import LandingNeeds
from autonomy.perception.surface_match import SurfaceMatcher

__all__ = [
    "AnchorFix",
    "DepthImage",
    "ElevationMap",
    "LandingMap",
    "LandingNeeds",
    "LandingSite",
    "MapAnchor",
    "MapAnchorCfg",
    "MapMatcher",
    "MoverTracker",
    "MoverTrackerCfg",
    "SurfaceMatcher",
    "assess",
    "camera_pose",
    "choose_site",
    "objection",
    "site_at",
]
