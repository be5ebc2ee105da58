"""The scene document: objects, hierarchy, landing areas, relief; its JSON and its categories."""

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
