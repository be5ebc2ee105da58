"""Networks of Stable-Baselines3 files: their weights, and nothing else of the file.

Such a file is a zip that holds pickles, and a pickle can run any program when it is loaded. So only
`policy.pth` is read, by torch's loader for weights alone, and the description beside the file
states which of them are the layers. All sizes are checked before anything is unpacked.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from scenarios.policies.description import Network, PolicyError

MOST_BYTES = 64 << 20
"""Greatest size of a policy's file, and of its weights: 16 million numbers."""
_WEIGHTS = "policy.pth"
_MOST_ENTRIES = 10_000


def read_layers(
    path: Path, data: bytes, network: Network, n_inputs: int, n_outputs: int
) -> Callable[[Float[np.ndarray, " k"]], Float[np.ndarray, " a"]]:
    """Return the function of an observation's numbers that a Stable-Baselines3 file holds.

    Args:
        path: Its name, for messages.
        data: Its content.
        network: Which of its weights are the layers.
        n_inputs: Size of an observation.
        n_outputs: Size of an action.

    Raises:
        PolicyError: If it is damaged, too large, holds more than weights, or has other shapes.
    """
    weights = _weights(path, data)
    layers = []
    n = n_inputs
    for number, name in enumerate(network.layers):
        n_next = n_outputs if number == len(network.layers) - 1 else None
        weight = _tensor(path, weights, f"{name}.weight", (n_next, n))
        n = weight.shape[0]
        layers.append((weight, _tensor(path, weights, f"{name}.bias", (n,))))
    return _forward(layers, network)


def _forward(layers: list[tuple[Any, Any]], network: Network) -> Callable[[np.ndarray], np.ndarray]:
    """Return the network as a function; torch computes it, so that it equals its training."""
    import torch

    between = {"tanh": torch.tanh, "relu": torch.relu, "elu": torch.nn.functional.elu}
    activate, last = between[network.activation], len(layers) - 1

    def act(observation: np.ndarray) -> np.ndarray:
        with torch.inference_mode():
            numbers = torch.from_numpy(observation)[None]
            for i, (weight, bias) in enumerate(layers):
                numbers = torch.nn.functional.linear(numbers, weight, bias)
                if i < last:
                    numbers = activate(numbers)
            if network.is_squashed:
                numbers = torch.tanh(numbers)
            return numbers[0].numpy()

    return act


def _weights(path: Path, data: bytes) -> dict[str, Any]:
    """Return the tensors of a file by their names.

    Raises:
        PolicyError: As `read_layers` does.
    """
    import torch

    try:
        packed = _member(path, data)
        _require_plain(path, packed)
        found = torch.load(io.BytesIO(packed), map_location="cpu", weights_only=True)
    except PolicyError:
        raise
    except Exception as error:  # noqa: BLE001 - a damaged file may raise nearly anything
        first = str(error).strip().split("\n")[0].split(". ")[0]
        raise PolicyError(
            f"policy {str(path)!r}: {_WEIGHTS} holds no weights alone: {first or type(error)}; "
            "valid: what Stable-Baselines3 has saved"
        ) from None
    if not isinstance(found, dict):
        raise PolicyError(f"policy {str(path)!r}: {_WEIGHTS} is no table of weights by their names")
    return found


def _member(path: Path, data: bytes) -> bytes:
    """Return the packed weights of a file, unpacked within bounds.

    Raises:
        PolicyError: If it is no zip, or has none, or they are too large.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if len(archive.infolist()) > _MOST_ENTRIES or _WEIGHTS not in archive.namelist():
                raise PolicyError(
                    f"policy {str(path)!r} has no {_WEIGHTS}; valid: what Stable-Baselines3 saved"
                )
            # Bounded while it is unpacked: the size that the archive states may be a lie.
            with archive.open(_WEIGHTS) as file:
                packed = file.read(MOST_BYTES + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, ValueError) as error:
        if isinstance(error, PolicyError):
            raise
        raise PolicyError(
            f"policy {str(path)!r} is no Stable-Baselines3 file: {error}; "
            "valid: what its save() has written"
        ) from None
    if len(packed) > MOST_BYTES:
        raise PolicyError(
            f"policy {str(path)!r}: {_WEIGHTS} holds more than {MOST_BYTES >> 20} MiB; "
            "valid: at most that"
        )
    return packed


def _require_plain(path: Path, packed: bytes) -> None:
    """Refuse packed tensors that are compressed: torch's own are not, and would unpack unbounded.

    Raises:
        PolicyError: If any is, or there are too many.
    """
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        entries = archive.infolist()
    is_plain = all(
        entry.compress_type == zipfile.ZIP_STORED and entry.file_size == entry.compress_size
        for entry in entries
    )
    if not is_plain or sum(entry.file_size for entry in entries) > MOST_BYTES:
        raise PolicyError(
            f"policy {str(path)!r}: {_WEIGHTS} is compressed within; valid: what torch.save wrote"
        )


def _tensor(path: Path, weights: dict[str, Any], name: str, shape: tuple[int | None, ...]) -> Any:
    """Return a tensor of a shape, in which None admits any size.

    Raises:
        PolicyError: If it is missing, or no array of finite 32-bit numbers of that shape.
    """
    import torch

    found = weights.get(name)
    wanted = tuple("any" if n is None else n for n in shape)
    valid = f"valid: float32 of shape {wanted}".replace("'", "")
    if not isinstance(found, torch.Tensor):
        raise PolicyError(f"policy {str(path)!r} has no tensor {name!r}; {valid}")
    has_shape = found.ndim == len(shape) and all(
        wanted in {None, n} for wanted, n in zip(shape, found.shape, strict=True)
    )
    # A tensor may claim more numbers than the file holds, all of them at one place.
    # A tensor of the device "meta" has no numbers at all.
    is_whole = (
        found.numel() * 4 <= MOST_BYTES
        and found.layout is torch.strided
        and found.device.type == "cpu"
    )
    if not has_shape or not is_whole or found.dtype is not torch.float32:
        kind = str(found.dtype).removeprefix("torch.")
        raise PolicyError(
            f"policy {str(path)!r}: {name!r} is {kind} of shape {tuple(found.shape)}; {valid}"
        )
    if not torch.isfinite(found).all():
        raise PolicyError(f"policy {str(path)!r}: {name!r} has numbers that are not finite")
    return found.detach().contiguous()
