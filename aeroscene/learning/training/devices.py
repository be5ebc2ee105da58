"""The choice of a computing device, and clear errors if its memory does not suffice."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch

from aeroscene.scene import SceneError

AUTO = "auto"
_CPU_ALLOCATION = "DefaultCPUAllocator"
"""Part of PyTorch's message if main memory is exhausted, for which it has no exception."""


class DeviceError(SceneError):
    """A device is missing or too small; one line has the way out."""


def choose_device(name: str) -> torch.device:
    """Return the device that a user names.

    Args:
        name: `auto` for a GPU if there is one, and the processor otherwise; or a device as PyTorch
            calls it: `cpu`, `cuda`, `cuda:1`, `mps`.

    Raises:
        DeviceError: If there is no such device here.
    """
    if name == AUTO:
        return torch.device("cuda" if torch.cuda.is_available() else "cpu")
    present = _present()
    # `cuda` without a number is the first GPU.
    if name not in present and f"{name}:0" not in present:
        raise DeviceError(
            f"device {name!r} is not there, valid here: {', '.join((AUTO, *present))} "
            f"(PyTorch {torch.__version__})"
        )
    return torch.device(name)


def _present() -> tuple[str, ...]:
    names = ["cpu", *(f"cuda:{number}" for number in range(torch.cuda.device_count()))]
    if torch.backends.mps.is_available():
        names.append("mps")
    return tuple(names)


@contextmanager
def naming_memory(device: torch.device, way_out: str) -> Iterator[None]:
    """Turn a lack of memory inside of the block into one line that says what needs less.

    Args:
        device: Device that computes.
        way_out: Advice such as "a smaller --batch-size than 64".

    Raises:
        DeviceError: If memory runs out inside.
    """
    try:
        yield
    except (torch.OutOfMemoryError, MemoryError) as error:
        raise DeviceError(_out_of_memory(device, way_out)) from error
    except RuntimeError as error:
        # Other runtime errors are not about memory.
        if _CPU_ALLOCATION not in str(error):
            raise
        raise DeviceError(_out_of_memory(device, way_out)) from error


def _out_of_memory(device: torch.device, way_out: str) -> str:
    return f"device {str(device)!r} is out of memory; valid: {way_out}"
