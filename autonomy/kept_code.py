"""Machine code of kernels on disk: its folder, and what happens if that cannot be written.

A container or a job of CI often has no home folder, or one that cannot be written. numba then
refuses to compile at all. Here the code that is already in the folder is still read, new code stays
in memory, and one line says so.
"""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self

import platformdirs
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator

_REPORT = logging.getLogger("aeroscene.cache")


def cache_root() -> Path | None:
    """The folder of all that is kept between runs; it may not be there yet.

    Returns:
        `AEROSCENE_CACHE_DIR`, else the user's cache folder. None if `AEROSCENE_CACHE=off`, or if
        the user has no home folder.
    """
    if os.environ.get("AEROSCENE_CACHE", "").lower() == "off":
        return None
    if named := os.environ.get("AEROSCENE_CACHE_DIR"):
        return Path(named).absolute()
    try:
        root = Path(platformdirs.user_cache_dir("aeroscene"))
    except RuntimeError:
        return None
    return root if root.is_absolute() else None


def report_unkept(reason: str) -> None:
    """Log once that kernels are compiled for this run alone."""
    if not _REPORT.disabled:
        _REPORT.warning(
            "no cache, kernels compile anew in each run: %s; "
            "set AEROSCENE_CACHE_DIR to a folder that can be written",
            reason,
        )
        _REPORT.disabled = True


class _Folder(UserProvidedCacheLocator):
    """The folder that numba's setting names, also if it can only be read."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Self:
        """Take the folder without a look whether it can be written to; saving does that."""
        return cls(py_func, py_file)


class _Impl(CompileResultCacheImpl):
    _locator_classes = (_Folder,)


class KernelCache(FunctionCache):
    """numba's cache of one function, which an unusable folder makes useless, not fatal."""

    _impl_class = _Impl

    @contextlib.contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        """Report an error of reading or writing, which numba does within this."""
        try:
            yield
        except OSError as error:
            report_unkept(f"{cache_root()}: {(error.strerror or str(error)).lower()}")
