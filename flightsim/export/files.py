"""Files of an export: written whole or not at all, with a clear error for an unusable folder."""

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
    """An export cannot be written; the message is one line that says what to do."""


@contextlib.contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Staging folder beside `folder`; its entries are moved there when all are written.

    Raises:
        ExportError: If the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(prefix=".export-", dir=folder))
    except OSError as error:
        raise ExportError(
            f"out {str(folder)!r} cannot be written ({error.strerror}), "
            "valid: a folder that you may write to"
        ) from None
    try:
        yield stage
        _move_over(stage, folder)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def _move_over(stage: Path, folder: Path) -> None:
    for source in sorted(path for path in stage.rglob("*") if path.is_file()):
        target = folder / source.relative_to(stage)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(source, target)  # noqa: PTH105 - as atomic as the system allows


def write_png(path: Path, rgb: np.ndarray) -> None:
    """Write a picture, uint8 (h, w, 3), top row first."""
    import cv2  # noqa: PLC0415 - heavy, and only exports with textures need it

    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), rgb[:, :, ::-1])


def write_texture(path: Path, texture: str, rgba: tuple[float, float, float, float]) -> None:
    """Write one tile of a material's texture in its colour."""
    write_png(path, tile(texture, rgba[:3]))
