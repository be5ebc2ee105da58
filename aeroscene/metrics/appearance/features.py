"""Features of pictures by a named network: EfficientNet-Lite0, or Inception from a user's file.

FID is defined for the Inception network alone. No package ships its standard file, so the user may
pass it. Otherwise a network that pip can install is taken, and its distances get names of their
own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float, UInt8
from torch import Tensor

from aeroscene.metrics.appearance.efficientnet import N_FEATURES, NAME, load_efficientnet
from aeroscene.scene.errors import SceneError

Picture = UInt8[np.ndarray, "h w 3"]
# Pictures of a batch: few, so that memory suffices on any machine.
_BATCH = 8
N_INCEPTION_FEATURES = 2048


class NetworkError(SceneError):
    """A file holds no network for features; one line has the fault and a valid file."""


@dataclass(frozen=True)
class FeatureNetwork:
    """A network, and the names of distances of its features."""

    name: str
    """`EffNetL0` or `Inception`."""
    digest: str
    """Sixteen hexadecimal digits of its weights' file; for the default, the package's version."""
    n_features: int
    module: torch.nn.Module
    is_inception: bool

    @property
    def frechet_name(self) -> str:
        """Name of the Fréchet distance: FID with Inception, and with nothing else."""
        return "FID" if self.is_inception else f"FD-{self.name}"

    @property
    def kernel_name(self) -> str:
        """Name of the kernel distance."""
        return "KID" if self.is_inception else f"KID-{self.name}"

    def features(self, pictures: Sequence[Picture]) -> Float[np.ndarray, "n f"]:
        """Return the features of pictures of one size, one row for each picture."""
        starts = range(0, len(pictures), _BATCH)
        rows = [self._batch(pictures[start : start + _BATCH]) for start in starts]
        # An empty list of pictures gives an array without rows.
        return np.concatenate([np.zeros((0, self.n_features), dtype=np.float32), *rows])

    def _batch(self, pictures: Sequence[Picture]) -> np.ndarray:
        pixels = torch.from_numpy(np.stack(pictures)).permute(0, 3, 1, 2)
        with torch.no_grad():
            return _asked(self.module, pixels, is_inception=self.is_inception).numpy()


def _asked(module: torch.nn.Module, pixels: Tensor, *, is_inception: bool) -> Tensor:
    if is_inception:
        # The published file has this signature.
        return module(pixels, return_features=True).float()
    return module(pixels.float())


def open_network(inception: Path | None = None) -> FeatureNetwork:
    """Open the network that compares pictures.

    Args:
        inception: TorchScript file of the standard Inception network, `inception-2015-12-05.pt` as
            published with StyleGAN2-ADA, which no package holds; None for EfficientNet-Lite0.

    Raises:
        MissingNetworkError: If the package with the default's weights is not installed.
        NetworkError: If the file is not such a network.
    """
    if inception is None:
        return FeatureNetwork(NAME, "0.1.0", N_FEATURES, load_efficientnet(), is_inception=False)
    where = f"inception {str(inception)!r}"
    try:
        digest = hashlib.sha256(inception.read_bytes()).hexdigest()[:16]
        module = torch.jit.load(str(inception), map_location="cpu").eval()
        # A blank picture shows if the file answers as the network does.
        blank = torch.zeros((1, 3, 64, 64), dtype=torch.uint8)
        shape = tuple(_asked(module, blank, is_inception=True).shape)
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise NetworkError(f"{where} cannot be read ({reason}); valid: {_VALID}") from None
    except (RuntimeError, ValueError, TypeError, AttributeError) as error:
        reason = str(error).strip().splitlines()[-1] if str(error).strip() else type(error).__name__
        raise NetworkError(f"{where} is no such network ({reason}); valid: {_VALID}") from None
    if shape != (1, N_INCEPTION_FEATURES):
        raise NetworkError(
            f"{where} gives features of shape {shape}; valid: (1, {N_INCEPTION_FEATURES}); {_VALID}"
        )
    return FeatureNetwork("Inception", digest, N_INCEPTION_FEATURES, module, is_inception=True)


_VALID = "inception-2015-12-05.pt, the TorchScript file of StyleGAN2-ADA"
