"""The scene document: objects, hierarchy, landing areas and relief, its JSON and its categories.

A scene is the one thing that generators, layouts, maps, worlds, planners and metrics have in
common. It is a frozen dataclass that validates itself, so no other module needs to check a scene
again.
"""

from aeroscene.scene.box import OrientedBox, Quaternion, Vector3
from aeroscene.scene.errors import SceneError
from aeroscene.scene.relief import Relief
from aeroscene.scene.scene import (
    DOMAINS,
    AreaKind,
    AttributeValue,
    DroneClass,
    InteractionArea,
    ObjectDomain,
    Scene,
    SceneDomain,
    SceneObject,
)

__all__ = [
    "DOMAINS",
    "AreaKind",
    "AttributeValue",
    "DroneClass",
    "InteractionArea",
    "ObjectDomain",
    "OrientedBox",
    "Quaternion",
    "Relief",
    "Scene",
    "SceneDomain",
    "SceneError",
    "SceneObject",
    "Vector3",
]
