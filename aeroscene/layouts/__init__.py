"""Layouts that are not ours: read, mapped to our categories, and made flyable.

`neutral_format`, `aeroscene_json`, `front3d` and `thor` read one form each into a `NeutralLayout`.
`mapping` finds our category for each name of a source, and `flyable` adds ground, walls and a
start. Importing this package loads numpy at most; building a scene loads shapely.
"""

from aeroscene.layouts.document import LayoutError, LayoutObject, LayoutRoom, NeutralLayout
from aeroscene.layouts.mapping import MappingReport
from aeroscene.layouts.neutral_format import read_neutral
from aeroscene.layouts.reader import pick_layout, read_layout, read_layouts

__all__ = [
    "LayoutError",
    "LayoutObject",
    "LayoutRoom",
    "MappingReport",
    "NeutralLayout",
    "pick_layout",
    "read_layout",
    "read_layouts",
    "read_neutral",
]
