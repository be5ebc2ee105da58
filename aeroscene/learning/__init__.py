"""The AeroScene model: tokens, skeleton, diffusion, guidance, training, generation."""

import importlib
import os

from aeroscene.scene.errors import SceneError

# PyTorch's threads wait for each other asleep. Awake, where other processes want the cores too, a
# scene took 11.6 s of them instead of 2.5; no effect once PyTorch is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


class MissingTorchError(SceneError):
    """PyTorch, which the scene model computes with, is not installed."""


def require_torch() -> None:
    """Refuse in one line where the scene model cannot be used, before anything loads it.

    Raises:
        MissingTorchError: If the extra `model` is not installed.
    """
    try:
        for name in ("torch", "safetensors"):
            importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name not in {"torch", "safetensors"}:
            raise
        raise MissingTorchError(
            f"the scene model needs {error.name}, which is not installed: "
            "pip install 'aeroscene[model]'; the scenes that come with the package fly without it"
        ) from None
