"""Places that exist: OpenStreetMap and GeoJSON as scenes to fly in.

`reader` reads a file into features, and `place` projects and cuts them. Then one module each
builds the ground, streets, buildings, barriers, furniture and trees, and `flyable` joins their
results to a scene.
"""

from aeroscene.maps.document import MapError
from aeroscene.maps.flyable import MapReport, open_map

__all__ = ["MapError", "MapReport", "open_map"]
