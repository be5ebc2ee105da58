"""Files: those of others are read within bounds, our own are written whole or not at all."""

from aeroscene.files.access import (
    UnpackError,
    cache_folder,
    open_regular,
    pieces,
    read_bounded,
    replacing,
)

__all__ = ["UnpackError", "cache_folder", "open_regular", "pieces", "read_bounded", "replacing"]
