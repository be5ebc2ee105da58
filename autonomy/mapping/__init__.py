"""Mapping: from depth images to known free space, and plans within it."""

from autonomy.mapping.exploring import plan_towards
from autonomy.mapping.map import GivenMap, Map
from autonomy.mapping.seen_map import SeenMap
from autonomy.mapping.seen_map_cfg import SeenMapCfg

__all__ = ["GivenMap", "Map", "SeenMap", "SeenMapCfg", "plan_towards"]
