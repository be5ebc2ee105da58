"""Objects that hang from a ceiling instead of standing on something."""

from __future__ import annotations

from aeroscene.scene.scene import SceneObject

PENDANT = "pendant"


def is_hung(obj: SceneObject) -> bool:
    """True if an object hangs from the ceiling of its room: its `form` is `PENDANT`."""
    return obj.attributes.get("form") == PENDANT
