"""Frames of a set of labelled images, read one by one.

The place of each file in a shard is found when the shard is first used, in about 10 ms. Images are
read on demand, so that a set may be larger than memory.
"""

from __future__ import annotations

import bisect
import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np

from scenarios.images.build import read_manifest
from scenarios.images.encoding import decoded
from scenarios.images.request import ImagesError
from scenarios.images.shard import frame_key


class FrameReader:
    """Files of all frames of a set, by the place of the frame in it.

    Attributes:
        folder: Folder of the set.
        n_frames: Number of frames in whole shards.
    """

    def __init__(self, folder: Path | str) -> None:
        """Read the manifest.

        Raises:
            ImagesError: If the folder holds no frames.
        """
        self.folder = Path(folder)
        manifest = read_manifest(self.folder)
        if manifest is None or not manifest.shards:
            raise ImagesError(
                f"{str(folder)!r} holds no labelled images; valid: a folder of `aeroscene images`"
            )
        self._shards = manifest.shards
        # Number of frames before each shard: an unfinished set may lack shards in between.
        self._first = np.cumsum([0, *(shard.n_frames for shard in self._shards)]).tolist()
        self.n_frames = self._first[-1]
        self._places: dict[int, dict[str, tuple[int, int]]] = {}

    def shard_and_key(self, index: int) -> tuple[int, str]:
        """Return the place of a frame's shard among the shards, and the name of its files.

        Args:
            index: Place of the frame in the set; negative counts from the end.

        Raises:
            IndexError: If there is no such frame.
        """
        if not -self.n_frames <= index < self.n_frames:
            raise IndexError(f"frame {index} is not among {self.n_frames}")
        index %= self.n_frames
        shard = bisect.bisect_right(self._first, index) - 1
        return shard, frame_key(self._shards[shard].first_frame + index - self._first[shard])

    def read(self, index: int, suffix: str) -> bytes:
        """Return a file of a frame.

        Args:
            index: Place of the frame in the set.
            suffix: Ending of the file, see `scenarios.images.encoding.SUFFIXES`.

        Raises:
            ImagesError: If the shard is damaged.
        """
        shard, key = self.shard_and_key(index)
        path = self.folder / self._shards[shard].file
        try:
            if shard not in self._places:
                with tarfile.open(path) as tar:
                    self._places[shard] = {m.name: (m.offset_data, m.size) for m in tar}
            offset, size = self._places[shard][f"{key}.{suffix}"]
            # Opened for each file: the processes of a `DataLoader` cannot share file objects.
            with path.open("rb") as file:
                file.seek(offset)
                return file.read(size)
        except (KeyError, tarfile.TarError) as error:
            raise ImagesError(
                f"shard {str(path)!r} is damaged ({error}); valid: as it was made"
            ) from None

    def image(self, index: int, suffix: str) -> np.ndarray:
        """Return the pixels of an image of a frame, with red first.

        Raises:
            ImagesError: If the image is damaged.
        """
        return decoded(self.read(index, suffix), f"frame {index} of {str(self.folder)!r}")

    def facts(self, index: int) -> dict[str, Any]:
        """Return the facts of a frame: scene, light, camera, poses, instances, areas."""
        return json.loads(self.read(index, "json"))
