"""Files of an export: written whole or not at all, with a clear error for an unusable folder.

An export is several files that belong together. They are written into a hidden folder beside their
place and moved at the end, so that a full disk or an interrupt leaves the former export as it was.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from flightsim.looks.textures import tile


class ExportError(ValueError):
    """An export cannot be written; the message is one line that says how to mend that."""


@contextlib.contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Yield a folder to write into; its files are moved to `folder` when all are written.

    Args:
        folder: Destination, which is made if it is missing; files of equal names are replaced.

    Raises:
        ExportError: If the folder cannot be written, or has no room for all of it.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Inside of the destination: a move to another disk would be a copy.
        stage = Path(tempfile.mkdtemp(prefix=".export-", dir=folder))
    except OSError as error:
        raise _unwritable(folder, error) from None
    try:
        yield stage
        _move_over(stage, folder)
    except OSError as error:
        raise _unwritable(folder, error) from None
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def _unwritable(folder: Path, error: OSError) -> ExportError:
    reason = error.strerror or str(error)
    return ExportError(
        f"out {str(folder)!r} cannot be written ({reason.lower()}); "
        "valid: a folder that you may write to, with room"
    )


def _move_over(stage: Path, folder: Path) -> None:
    # Sorted, so that the order does not depend on the disk.
    for source in sorted(path for path in stage.rglob("*") if path.is_file()):
        target = folder / source.relative_to(stage)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(source, target)  # noqa: PTH105 - as atomic as the system allows


def write_png(path: Path, rgb: np.ndarray) -> None:
    """Write a picture, uint8 (h, w, 3), top row first."""
    import cv2

    path.parent.mkdir(parents=True, exist_ok=True)
    _, encoded = cv2.imencode(".png", np.ascontiguousarray(rgb[:, :, ::-1]))
    # Not cv2.imwrite, which raises nothing on a full disk.
    path.write_bytes(encoded.tobytes())


def write_texture(path: Path, texture: str, rgba: tuple[float, float, float, float]) -> None:
    """Write one tile of a material's texture in its colour.

    Args:
        path: PNG file to write.
        texture: Name of the texture.
        rgba: Colour of the material; its alpha is left out.
    """
    write_png(path, tile(texture, rgba[:3]))
