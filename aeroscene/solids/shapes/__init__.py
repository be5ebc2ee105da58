"""Shapes of objects: the primitives by which each category is seen and touched. Pure data."""

from aeroscene.solids.shapes.build import SHAPES, object_primitives, scene_primitives
from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.materials import MATERIALS, Material
from aeroscene.solids.shapes.primitive import Part, Primitive

__all__ = [
    "FORMS",
    "MATERIALS",
    "SHAPES",
    "Material",
    "Part",
    "Primitive",
    "object_primitives",
    "scene_primitives",
]
