"""Surroundings of an outdoor site: streets that continue, houses and trees, outside its volume."""

from aeroscene.neighbourhood.neighbourhood import GAP_M, RING_M, neighbours_of
from aeroscene.neighbourhood.shapes import NEIGHBOUR_OBJECT_ID
from aeroscene.neighbourhood.style import NEIGHBOURHOOD_STYLES

__all__ = ["GAP_M", "NEIGHBOURHOOD_STYLES", "NEIGHBOUR_OBJECT_ID", "RING_M", "neighbours_of"]
