"""The AeroScene dataset as it ships: all scenes in one compact file, each opened by its number."""

from aeroscene.shipped.archive import Archive, ArchiveError, Provenance, open_archive, write_archive
from aeroscene.shipped.scenes import SHIPPED, ArchivedScenes, open_shipped, read_shipped

__all__ = [
    "SHIPPED",
    "Archive",
    "ArchiveError",
    "ArchivedScenes",
    "Provenance",
    "open_archive",
    "open_shipped",
    "read_shipped",
    "write_archive",
]
