"""Memory card of the camera: a folder of the user's, or none, with a limit on its use.

Clients decide how many pictures are taken, so one run could fill the user's disk. The card has a
capacity for that reason, and it never overwrites a file, so a folder can serve many runs.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from aeroscene.files import replacing

CAPACITY_BYTES = 1 << 30
"""Greatest number of bytes that one run writes, whatever clients ask for."""


class CardFullError(OSError):
    """The card has no room for more."""


class Card:
    """Files of one run, none of which replaces another file.

    Attributes:
        folder: Folder of the files; None keeps nothing.
        used_bytes: Bytes that this run has written.
    """

    def __init__(self, folder: Path | None) -> None:
        """Use a folder, which is made with its parents if it is missing.

        Args:
            folder: Folder for pictures; None keeps none.

        Raises:
            OSError: If it cannot be made.
        """
        self.folder = folder
        self.used_bytes = 0
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    @property
    def free_bytes(self) -> int:
        """Room that is left, the least of the card's and the disk's; 0 without a folder."""
        if self.folder is None:
            return 0
        return max(0, min(CAPACITY_BYTES - self.used_bytes, shutil.disk_usage(self.folder).free))

    def new_path(self, kind: str, suffix: str) -> Path | None:
        """Return a path for the next file of a kind, such as IMG_0007.jpg.

        Numbers go on after the greatest in the folder, as on a real camera, also from earlier runs.

        Args:
            kind: Beginning of the name, such as IMG.
            suffix: End of the name with its dot.

        Returns:
            A path that no file has yet; None without a folder.
        """
        if self.folder is None:
            return None
        taken = (path.stem.removeprefix(f"{kind}_") for path in self.folder.glob(f"{kind}_*"))
        number = 1 + max((int(number) for number in taken if number.isdecimal()), default=-1)
        return self.folder / f"{kind}_{number:04d}{suffix}"

    def write(self, path: Path, data: bytes) -> None:
        """Write a file whole or not at all, and count its bytes.

        Args:
            path: Where to write it, inside the folder.
            data: Content of the file.

        Raises:
            CardFullError: If it does not fit.
            OSError: If the disk refuses it.
        """
        self.require(len(data))
        with replacing(path) as file:
            file.write(data)
        self.used_bytes += len(data)

    def require(self, n_bytes: int) -> None:
        """Refuse a number of bytes that does not fit.

        Raises:
            CardFullError: If there is less room.
        """
        if n_bytes > self.free_bytes:
            raise CardFullError(f"{self.folder} has no room for {n_bytes} bytes more")
