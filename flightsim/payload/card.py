"""Memory card of the camera: a folder of the user's, or none, with a bound on what it takes."""

from __future__ import annotations

import shutil
from pathlib import Path

from aeroscene.files import replacing

CAPACITY_BYTES = 1 << 30
"""Most that one run writes, whatever clients ask for."""


class CardFullError(OSError):
    """The card has no room for more."""


class Card:
    """Files of one run, none of which takes the place of another.

    Attributes:
        folder: Where the files are; None keeps nothing.
        used_bytes: What this run has written.
    """

    def __init__(self, folder: Path | None) -> None:
        """Use a folder, which is made if only that is missing.

        Raises:
            OSError: If it cannot be made.
        """
        self.folder = folder
        self.used_bytes = 0
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    @property
    def free_bytes(self) -> int:
        """Room that is left; 0 without a folder."""
        if self.folder is None:
            return 0
        return max(0, min(CAPACITY_BYTES - self.used_bytes, shutil.disk_usage(self.folder).free))

    def new_path(self, kind: str, suffix: str) -> Path | None:
        """Path for the next file of a kind, such as IMG_0007.jpg; None without a folder."""
        if self.folder is None:
            return None
        taken = (path.stem.removeprefix(f"{kind}_") for path in self.folder.glob(f"{kind}_*"))
        number = 1 + max((int(number) for number in taken if number.isdecimal()), default=-1)
        return self.folder / f"{kind}_{number:04d}{suffix}"

    def write(self, path: Path, data: bytes) -> None:
        """Write a file whole or not at all.

        Raises:
            CardFullError: If it does not fit.
            OSError: If the disk refuses it.
        """
        self.require(len(data))
        with replacing(path) as file:
            file.write(data)
        self.used_bytes += len(data)

    def require(self, n_bytes: int) -> None:
        """Refuse what does not fit.

        Raises:
            CardFullError: If there is less room.
        """
        if n_bytes > self.free_bytes:
            raise CardFullError(f"{self.folder} has no room for {n_bytes} bytes more")
