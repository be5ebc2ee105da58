"""Perception: from depth images to landing sites, moving obstacles and the place in a given map."""

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
from autonomy.perception.map_anchor import AnchorFix, MapAnchor
from autonomy.perception.map_anchor_cfg import MapAnchorCfg
from autonomy.perception.mover_tracker import MoverTracker, MoverTrackerCfg
from autonomy.perception.needs import LandingNeeds

__all__ = [
    "AnchorFix",
    "DepthImage",
    "ElevationMap",
    "LandingMap",
    "LandingNeeds",
    "LandingSite",
    "MapAnchor",
    "MapAnchorCfg",
    "MoverTracker",
    "MoverTrackerCfg",
    "assess",
    "camera_pose",
    "choose_site",
    "objection",
    "site_at",
]
