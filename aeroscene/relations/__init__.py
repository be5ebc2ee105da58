"""Relations before positions: what each fine object or group is to its host, and what that pins."""

from aeroscene.relations.parsing.reading import scene_relations
from aeroscene.relations.placing import place
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
