"""The AeroScene scene model: programs, writer, diffusion, training, generation.

Importing this package loads no PyTorch, so that commands can check their arguments and files first.
Call `require_torch` before you import a submodule that computes.
"""

import os
from importlib.util import find_spec

from aeroscene.scene.errors import SceneError

# PyTorch's threads wait for each other asleep. Awake, where other processes want the cores too, a
# scene took 11.6 s of CPU time instead of 2.5. The variable is read when PyTorch loads, so it has
# no effect later. A value that the user has set stays.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


class MissingTorchError(SceneError):
    """PyTorch, which the scene model computes with, is not installed."""


def require_torch() -> None:
    """Refuse in one line if the scene model cannot be used.

    The function looks for PyTorch without loading it. A command can therefore refuse a missing
    extra at once, before it spends seconds on imports.

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
    except ImportError:  # An import hook may raise this instead of returning None.
        return False
