"""Relief of a site that was laid out on flat ground: swells, banks and mounds in its green.

Sites are laid out flat, because grammar and model place objects in the plane. The land rises
afterwards, only where nothing needs level ground, and `level` undoes it for metrics and learning.
"""

from aeroscene.landform.objects import level, on_relief, standing_points
from aeroscene.landform.relief import raise_relief

__all__ = ["level", "on_relief", "raise_relief", "standing_points"]
