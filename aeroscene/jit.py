"""Compiled kernels whose kept machine code is never stale.

numba's own cache looks at the file of the compiled function only: after an edit of a function that
lives in another file it serves the old code. So each kernel's code is kept in a folder that is
named by a hash of its module and of all modules of the same package that this one imports.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import hashlib
import logging
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self, TypeVar

import numba
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator

from aeroscene.files import cache_folder

_REPORT = logging.getLogger("aeroscene.cache")
"""Logger of the one line. `autonomy/kept_code.py` has the same; whoever is first disables it."""
_config: Any = config  # its names are made at run time
_F = TypeVar("_F", bound=Callable[..., Any])


def kernel(function: _F) -> _F:
    """Compile a function on its first call and keep the code, if there is a folder for it."""
    compiler: Any = numba.njit  # its annotations leave options out
    compiled = compiler(error_model="numpy")(function)
    folder = _folder(function.__module__)
    if folder is not None:
        before, _config.CACHE_DIR = _config.CACHE_DIR, str(folder)
        try:
            compiled._cache = _KernelCache(function)
        finally:
            _config.CACHE_DIR = before  # numba's settings stay as they are
    return compiled


class _Folder(UserProvidedCacheLocator):
    """The folder that numba's setting names, also if it can only be read."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Self:
        """Take the folder without a look whether it can be written to; saving does that."""
        return cls(py_func, py_file)


class _Impl(CompileResultCacheImpl):
    _locator_classes = (_Folder,)


class _KernelCache(FunctionCache):
    """numba's cache of one function, which an unusable folder makes useless, not fatal."""

    _impl_class = _Impl

    @contextlib.contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        """Report an error of reading or writing, which numba does within this."""
        try:
            yield
        except OSError as error:
            if not _REPORT.disabled:
                _REPORT.warning(
                    "no cache, kernels compile anew in each run: %s: %s; "
                    "set AEROSCENE_CACHE_DIR to a folder that can be written",
                    cache_folder(""),
                    (error.strerror or str(error)).lower(),
                )
                _REPORT.disabled = True


@functools.cache
def _folder(module: str) -> Path | None:
    """Where the code of a module's kernels is kept; None if nowhere."""
    kept = cache_folder("kernels")
    if kept is None:
        return None
    own = Path(str(sys.modules[module].__file__))
    package, *names = module.split(".")
    root = own.parents[len(names)]
    digest, waiting, seen = hashlib.blake2b(digest_size=8), [own], {own}
    while waiting:
        source = waiting.pop().read_bytes()
        digest.update(source)
        for name in _imported(source):
            stem = root.joinpath(*name.split("."))
            found = {stem.with_suffix(".py"), stem / "__init__.py"} - seen
            seen |= found
            if name.split(".")[0] == package:
                waiting += sorted(path for path in found if path.exists())
    return kept / module / digest.hexdigest()


def _imported(source: bytes) -> Iterator[str]:
    """Names that may be modules."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
