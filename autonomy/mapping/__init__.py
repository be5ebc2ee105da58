"""Mapping: from depth images to known free space, and plans within it.

`SeenMap` grows from images: `rays` turns an image into marks on cells, `cell_states` and `renewal`
keep distances up to date, and `plan_towards` (`exploring`, `errands`, `gestures`) explores with it.
`GivenMap` and `WideMap` are known before the flight. `plan_within` plans through any of them.
"""

from autonomy.mapping.agenda import Agenda
from autonomy.mapping.exploring import plan_towards
from autonomy.mapping.map import GivenMap, Map
from autonomy.mapping.plan import plan_within
from autonomy.mapping.seen_map import SeenMap
from autonomy.mapping.seen_map_cfg import SeenMapCfg
from autonomy.mapping.wide_map import WideMap

__all__ = [
    "Agenda",
    "GivenMap",
    "Map",
    "SeenMap",
    "SeenMapCfg",
    "WideMap",
    "plan_towards",
    "plan_within",
]
