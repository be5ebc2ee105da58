"""The folder in which is kept what took long to compute."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder(name: str) -> Path | None:
    """A folder in the user's cache, or in `AEROSCENE_CACHE_DIR`; it may not be there yet.

    Args:
        name: What is kept there.

    Returns:
        The folder, None where `AEROSCENE_CACHE=off` says that no file is read or written.
    """
    from platformdirs import user_cache_dir  # noqa: PLC0415 - only where the cache is used

    if os.environ.get("AEROSCENE_CACHE", "").lower() == "off":
        return None
    return Path(os.environ.get("AEROSCENE_CACHE_DIR") or user_cache_dir("aeroscene")) / name
