"""Relations before positions: each fine object's relation to its host, and the axes that it pins.

A position in metres says that a chair is at 3.27 m. A relation says that it stands at this table,
and leaves only centimetres of noise. `scene_relations` reads relations off a scene, and `place`
puts the boxes back exactly.
"""

from aeroscene.relations.parsing.reader import scene_relations
from aeroscene.relations.placement import place
from aeroscene.relations.relation import Align, Array, Gap, Kind, Member, Relation, Residual, Unit

__all__ = [
    "Align",
    "Array",
    "Gap",
    "Kind",
    "Member",
    "Relation",
    "Residual",
    "Unit",
    "place",
    "scene_relations",
]
