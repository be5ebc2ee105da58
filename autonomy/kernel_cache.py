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

# A logger of its own: disabling it after the first report leaves other messages alone.
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
    # Without a home folder some systems yield a path such as "~/.cache", which is no place to write
    # to.
    return root if root.is_absolute() else None


def report_unkept(reason: str) -> None:
    """Log, once per process, that kernels are compiled for this run alone.

    Args:
        reason: Cause in words, for the message.
    """
    if not _REPORT.disabled:
        _REPORT.warning(
            "no cache, kernels compile anew in each run: %s; "
            "set AEROSCENE_CACHE_DIR to a folder that can be written",
            reason,
        )
        _REPORT.disabled = True


_ROOT = Path(__file__).parents[1]


class _Folder(UserProvidedCacheLocator):
    """Cache locator for the folder that numba's setting names, even if it can only be read."""

    @classmethod
    def get_suitable_cache_subpath(cls, py_file: str) -> str:
        """Name a subfolder for the code of a file, without the path of our packages.

        numba hashes the path, so that a fresh checkout would compile every kernel again. The folder
        is named by a digest of our sources, and numba compares a digest of the file. Therefore
        checkouts with equal sources can share their code.

        Args:
            py_file: Source file of the kernel.
        """
        path = Path(py_file)
        if path.is_relative_to(_ROOT):
            return path.parent.name
        return super().get_suitable_cache_subpath(py_file)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Self:
        """Accept the folder without testing that it can be written to; saving finds that out."""
        return cls(py_func, py_file)


class _Impl(CompileResultCacheImpl):
    _locator_classes = [_Folder]  # noqa: RUF012 - a list in numba too


class KernelCache(FunctionCache):
    """Numba's cache of one function, which survives a folder that cannot be used.

    An error of reading or writing means a compilation in memory, not the end of the run.
    """

    _impl_class = _Impl

    # numba wraps each access to the folder in this method, so one override covers them all.
    @contextlib.contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        """Report an error of reading or writing, which numba does within this."""
        try:
            yield
        except OSError as error:
            report_unkept(f"{cache_root()}: {(error.strerror or str(error)).lower()}")
