"""The AeroScene dataset as it ships: all scenes in one compact file, each opened by its number."""

from aeroscene.corpus.shipped.archive import (
    Archive,
    ArchiveError,
    Provenance,
    open_archive,
    write_archive,
)
from aeroscene.corpus.shipped.scenes import (
    SHIPPED,
    ArchivedScenes,
    open_shipped,
    read_shipped,
    shipped_digest,
)

__all__ = [
    "SHIPPED",
    "Archive",
    "ArchiveError",
    "ArchivedScenes",
    "Provenance",
    "open_archive",
    "open_shipped",
    "read_shipped",
    "shipped_digest",
    "write_archive",
]
