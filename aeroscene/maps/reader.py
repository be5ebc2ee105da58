"""Map files of any known form: OSM XML, PBF or GeoJSON, distinguished by their names."""

from __future__ import annotations

import re
from pathlib import Path

from aeroscene.files import UnpackError, pieces, read_bounded
from aeroscene.maps.bounds import Bounds, is_rectangle, parse_bounds, require_size
from aeroscene.maps.document import Feature, MapError, RawMap
from aeroscene.maps.geojson import MOST_GEOJSON_BYTES, read_geojson
from aeroscene.maps.osm_features import features_of
from aeroscene.maps.osm_pbf import read_osm_pbf
from aeroscene.maps.osm_xml import read_osm_xml
from aeroscene.scene import SceneError

MAP_SUFFIXES = re.compile(r"\.(?:osm(?:\.gz|\.xml|\.pbf)?|pbf|geojson(?:\.gz)?)$")
"""Endings of the names of map files."""
MOST_OSM_BYTES = 256 << 20
"""Largest OSM XML file, unpacked; a square of 400 m in a city has under 20 MiB."""
_NEAR_M = 30.0
"""Distance outside the bounds up to which ways are read, so that streets reach the border."""


def read_map(path: Path, bounds_text: str | None) -> tuple[RawMap, Bounds]:
    """Read the features of a map file, and the bounds of the place.

    Args:
        path: File.
        bounds_text: West, south, east, north in degrees; None takes those of the file.

    Raises:
        SceneError: If the bounds are invalid or too large, before anything is read; or if the file
            breaks a rule.
    """
    bounds = None if bounds_text is None else parse_bounds(bounds_text)
    where = f"map file {str(path)!r}"
    raw = _read(path, where, bounds)
    if bounds is None:
        bounds = raw.bounds or _around(raw.features, where)
        require_size(bounds, f"{where} without bounds is")
    return raw, bounds


def _read(path: Path, where: str, bounds: Bounds | None) -> RawMap:
    try:
        if path.name.endswith(".pbf"):
            near = None if bounds is None else bounds.grown(_NEAR_M)
            return features_of(read_osm_pbf(path, where, near))
        # The last two suffixes, so that ".osm.gz" and ".osm.xml" count too.
        if ".osm" in path.suffixes[-2:]:
            return features_of(read_osm_xml(pieces(path, MOST_OSM_BYTES), where))
        return read_geojson(read_bounded(path, MOST_GEOJSON_BYTES), where)
    except UnpackError as error:
        raise MapError(f"{where}: {error}") from None
    except SceneError:
        raise
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
        raise MapError(f"{where} cannot be read ({reason}); valid: a map") from None


def _around(features: tuple[Feature, ...], where: str) -> Bounds:
    """The rectangle around all features."""
    import numpy as np
    import shapely

    if not features:
        raise MapError(f"{where} has no features; valid: at least one")
    x0, y0, x1, y1 = shapely.total_bounds(np.array([f.geometry for f in features])).tolist()
    found = Bounds(x0, y0, x1, y1)
    if not is_rectangle(found):
        raise MapError(f"{where} covers {found}; valid: a rectangle on the globe")
    return found
