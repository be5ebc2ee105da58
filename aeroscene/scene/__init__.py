"""The scene document: objects, hierarchy, landing areas; its JSON and its categories."""

from aeroscene.scene.box import OrientedBox, Quaternion, Vector3
from aeroscene.scene.errors import SceneError
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
    "Scene",
    "SceneDomain",
    "SceneError",
    "SceneObject",
    "Vector3",
]
