"""The AeroScene model: tokens, skeleton, diffusion, guidance, training, generation."""

import importlib

from aeroscene.scene.errors import SceneError


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
