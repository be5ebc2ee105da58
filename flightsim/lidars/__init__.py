"""Lidars: patterns of beams from files, and scans of the solids that they meet."""

from flightsim.lidars.definition import LIDARS, LidarCfg, LidarError, lidar_by_name
from flightsim.lidars.lidar import Lidar, LidarScan

__all__ = ["LIDARS", "Lidar", "LidarCfg", "LidarError", "LidarScan", "lidar_by_name"]
