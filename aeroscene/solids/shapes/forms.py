"""The variants of every category: values of the attribute `form`, which pins one of them.

Without the attribute the object's id picks. A form that a size has no room for falls back on the
first that fits; walls, floors and rooms vary by finish and colour.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

FORMS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "building": ("plain", "balconies", "ledges", "podium"),
        "house": ("plain", "veranda", "bay"),
        "tower": ("crown", "stepped", "ribs"),
        "warehouse": ("hall", "docks", "lowpitch"),
        "garage": ("garage", "shed", "carport"),
        "terrain": ("terrace", "ramp", "mound"),
        "kiosk": ("hatch", "round", "stall"),
        "container": ("closed", "open", "office"),
        "canopy": ("flat", "pitched", "solar"),
        "bridge": ("beam", "stairs", "truss"),
        "deck": ("platform", "posts", "edged"),
        "water": ("basin", "open", "planted"),
        "roof": ("flat", "gable", "hip", "shed"),
        "road": ("dashed", "edged", "arrows"),
        "sidewalk": ("slabs", "tactile", "banded"),
        "lawn": ("plain", "path", "beds"),
        "parking_lot": ("bays", "arrows", "marked"),
        "plaza": ("border", "bands", "cross"),
        "fence": ("hedge", "boards", "rails", "wall", "mesh"),
        "stairs": ("solid", "open", "cheeks"),
        "car": ("hatchback", "saloon", "estate", "suv", "pickup"),
        "van": ("panel", "minibus", "parcel"),
        "truck": ("box", "flatbed", "tanker"),
        "bus": ("city", "coach", "school"),
        "bicycle": ("city", "race", "cargo"),
        "tree": ("round", "spreading", "conical", "poplar", "birch"),
        "bush": ("clumps", "ball", "blossom"),
        "street_lamp": ("arm", "lantern", "twin"),
        "traffic_light": ("vehicle", "plate", "pedestrian"),
        "sign": ("plate", "round", "board"),
        "bench": ("rest", "plain", "stone"),
        "bin": ("wheelie", "litter", "dome"),
        "boat": ("rowing", "motor", "sailing"),
        "planter": ("trough", "pot", "flowers"),
        "crate": ("boards", "plastic", "chest"),
        "barrel": ("drum", "keg", "cask"),
        "pallet": ("bare", "boxes", "sacks", "bricks"),
        "landing_pad": ("letter", "rings", "cross"),
        "ac_unit": ("fan", "twin", "duct"),
        "chimney": ("stack", "pots", "flue"),
        "solar_panel": ("rack", "rows", "tent"),
        "water_tank": ("drum", "hat", "lying"),
        "antenna": ("bars", "dish", "cells"),
        "table": ("legs", "trestle", "round", "pedestal"),
        "chair": ("legs", "sled", "swivel", "upholstered"),
        "sofa": ("block", "cushions", "chaise"),
        "armchair": ("block", "wing", "tub"),
        "bed": ("boards", "divan", "posts"),
        "desk": ("drawers", "legs", "standing"),
        "cabinet": ("doors", "drawers", "sideboard"),
        "wardrobe": ("doors", "mirror", "open"),
        "shelf": ("open", "rack", "bookcase"),
        "coffee_table": ("panels", "round", "legs"),
        "nightstand": ("drawers", "open", "round"),
        "counter": ("kitchen", "bar", "sink"),
        "fridge": ("freezer", "double", "retro"),
        "stove": ("plates", "range", "island"),
        "television": ("foot", "legs", "bar"),
        "lamp": ("drum", "globe", "cone"),
        "plant": ("bushy", "palm", "blades"),
        "laptop": ("silver", "black", "white"),
        "monitor": ("flat", "pair", "thin"),
        "plate": ("flat", "bowl", "meal"),
        "cup": ("mug", "glass", "paper"),
        "cutlery": ("pair", "trio", "sticks"),
        "book": ("pile", "open", "upright"),
        "box": ("taped", "labelled", "tub"),
    }
)
"""Names of at least three forms under each category that has forms."""
