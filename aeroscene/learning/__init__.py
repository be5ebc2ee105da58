"""The AeroScene model: programs, writer, diffusion, training, generation."""

import os
from importlib.util import find_spec

from aeroscene.scene.errors import SceneError

# PyTorch's threads wait for each other asleep. Awake, where other processes want the cores too, a
# scene took 11.6 s of them instead of 2.5; no effect once PyTorch is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


class MissingTorchError(SceneError):
    """PyTorch, which the scene model computes with, is not installed."""


def require_torch() -> None:
    """Refuse in one line where the scene model cannot be used, before anything loads it.

    PyTorch itself is looked for and not loaded, so that files can be refused without it.

    Raises:
        MissingTorchError: If the extra `model` is not installed.
    """
    for name in ("torch", "safetensors"):
        if not _is_there(name):
            raise MissingTorchError(
                f"the scene model needs {name}, which is not installed: pip install "
                "'aeroscene[model]'; the scenes that come with the package fly without it"
            )


def _is_there(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ImportError:  # Whoever looks for modules may answer with this instead.
        return False
