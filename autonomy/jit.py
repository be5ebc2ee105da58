"""Compiled kernels: numba with a file cache that notices every change of a kernel's source.

numba's own cache looks only at the file of the compiled function. After an edit of a function that
lives in another file it would serve stale machine code. Here the cache directory of a module is
therefore named by a hash of its source and of all our modules that it imports, directly or not.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import hashlib
import importlib
import logging
import os
import re
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config
from numba.core.caching import FunctionCache, NullCache
from numba.np import linalg

from autonomy.kernel_cache import KernelCache, cache_root, report_unkept

_LOG = logging.getLogger(__name__)
_config: Any = config  # its names are created at run time
# The folder that holds our packages; sources are found below it by the names of modules.
_ROOT = Path(__file__).parents[1]
_IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+)?import\s+(\([^)]*\)|[^\n#]+)", re.MULTILINE)
_KEPT_CACHES = 4  # directories of a module that stay on disk, for example of several branches
_ANNOUNCED = "announced"
_F = TypeVar("_F", bound=Callable[..., Any])


def kernel(function: _F) -> _F:
    """Compile `function` on its first call (or by `compile_ahead`) and keep the code on disk.

    A function whose name begins with an underscore is part of another kernel: it is compiled with
    that one, cannot be called from Python and needs no cache of its own.
    """
    return _compiled(function, nogil=False)


def kernel_without_lock(function: _F) -> _F:
    """Compile like `kernel`, but release the interpreter's lock while the kernel runs.

    The plant uses it to step many worlds on several threads at once. Such a kernel must not share
    records with another thread.
    """
    return _compiled(function, nogil=True)


def _compiled(function: _F, *, nogil: bool) -> _F:
    is_part = function.__name__.startswith("_")
    compiler: Any = numba.njit  # its annotations lack options
    compiled = compiler(
        error_model="numpy",
        fastmath=False,
        no_cfunc_wrapper=True,
        no_cpython_wrapper=is_part,
        nogil=nogil,
    )(function)
    if not is_part:
        compiled._cache = _KeptCode(function)
    return compiled


class _KeptCode:
    """Numba's cache of a kernel, opened when the kernel's code is first looked for.

    Opening it late saves time at launch: to name its directory, all sources must be read that the
    kernel may call. Of the 125 kernels that a flight imports it asks for three, which hold the code
    of the others.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function

    @functools.cached_property
    def _opened(self) -> FunctionCache | NullCache:
        inherited, directory = _config.CACHE_DIR, cache_directory(self._function.__module__)
        if directory is None:
            return NullCache()
        _config.CACHE_DIR = str(directory)
        try:
            return KernelCache(self._function)
        finally:
            _config.CACHE_DIR = inherited  # nobody else's kernels belong under this digest

    def __getattr__(self, name: str) -> Any:
        return getattr(self._opened, name)


def fields(*names: str, kind: str = "f8", shape: tuple[int, ...] = ()) -> list[tuple[Any, ...]]:
    """Return fields of one type for the `np.dtype` of a kernel's record."""
    return [(name, kind, shape) for name in names]


@functools.cache
def cache_directory(module: str) -> Path | None:
    """Cache directory of a module's kernels, named by the hash of all sources that they may call.

    Returns:
        The directory, which may not exist and may not be writable. None if nothing is kept: the
            cache is off, or the user has no home folder.
    """
    kept = cache_root()
    if kept is None:
        if os.environ.get("AEROSCENE_CACHE", "").lower() != "off":
            report_unkept("the user has no home folder")
        return None
    digest = hashlib.blake2b(numba.__version__.encode(), digest_size=8)
    for path in sorted(_sources(_path_of(_ROOT, module)), key=str):
        digest.update(_bytes_of(path))
    root = kept / "kernels" / module
    directory = root / digest.hexdigest()
    with contextlib.suppress(OSError):  # such as a folder that cannot be read
        if not directory.exists():
            _forget_old_caches(root)
    return directory


def compile_ahead(
    compiled: Any, arguments: Sequence[object], title: str, expected_seconds: float
) -> None:
    """Compile a kernel for arguments of these types now, and announce it if it is not cached.

    Args:
        compiled: The kernel, as `kernel` returns it.
        arguments: Examples of its arguments; only their types count.
        title: Name of the kernel in the message.
        expected_seconds: Time of a cold compilation, for the message.
    """
    signature = tuple(numba.typeof(argument) for argument in arguments)
    if signature in compiled.overloads:
        return
    directory = cache_directory(compiled.__module__)
    mark = directory and directory / f"{compiled.__name__}.compiled"
    if mark is None or not os.access(mark, os.F_OK):
        _announce(title, expected_seconds, directory)
    _spare_linear_algebra()
    was_enabled = gc.isenabled()
    gc.disable()  # numba makes millions of lasting objects: a tenth of the time
    try:
        compiled.compile(signature)
    finally:
        if was_enabled:
            gc.enable()
    if mark is not None:
        with contextlib.suppress(OSError):
            mark.touch()


def _announce(title: str, expected_seconds: float, directory: Path | None) -> None:
    often = ", once" if directory is not None and _is_writable(directory) else ""
    _LOG.warning("compiling %s%s, about %.0f s", title, often, expected_seconds)


def _is_writable(directory: Path) -> bool:
    """Return whether a folder, or the nearest existing one above it, can be written to."""
    there = directory
    while not os.access(there, os.F_OK) and there != there.parent:
        there = there.parent
    return os.access(there, os.W_OK | os.X_OK)


def _spare_linear_algebra() -> None:
    """Keep numba from importing `scipy.linalg` merely to see that SciPy is installed.

    We depend on SciPy, so it is there, and the import takes a tenth of a launch. A kernel that uses
    linear algebra still imports it.
    """
    look = linalg.ensure_blas
    linalg.ensure_blas = _know
    try:
        importlib.import_module("numba.np.arraymath")  # The one that looks before it is needed.
    finally:
        linalg.ensure_blas = look


def _know() -> None:
    """Find SciPy's linear algebra without a look."""


def announce_if_cold(modules: Sequence[str], title: str, expected_seconds: float) -> None:
    """Announce that the kernels of modules will compile on their first use, unless they are cached.

    Some kernels stay uncompiled until a later flight uses them. A mark in the cache directory
    therefore keeps a module from being announced again.

    Args:
        modules: Names of the modules with the kernels.
        title: Name of the kernels in the message.
        expected_seconds: Time of a cold compilation, for the message.
    """
    directories = [cache_directory(module) for module in modules]
    cold = [d for d in directories if d is None or not _was_announced(d)]
    if not cold:
        return
    _announce(title, expected_seconds, cold[0])
    for directory in filter(None, cold):
        with contextlib.suppress(OSError):  # where nothing can be kept, all is compiled again
            directory.mkdir(parents=True, exist_ok=True)
            (directory / _ANNOUNCED).touch()


def _was_announced(directory: Path) -> bool:
    """Return whether a cache holds code already, or will once somebody uses it."""
    if not os.access(directory, os.R_OK | os.X_OK):
        return False
    return any(directory.rglob("*.nbi")) or (directory / _ANNOUNCED).exists()


@functools.cache
def _path_of(root: Path, module: str) -> Path | None:
    """Source file of one of our modules, None for others; many name the same ones."""
    stem = os.path.join(root, *module.split("."))  # noqa: PTH118 - a fifth of pathlib's time
    for name in (f"{stem}.py", f"{stem}/__init__.py"):
        if os.path.exists(name):  # noqa: PTH110 - as above
            return Path(name)
    return None


def _sources(first: Path | None) -> set[Path]:
    """Return a source file and all of ours that it imports, directly or indirectly."""
    found: set[Path] = set()
    waiting = [first]
    while waiting:
        path = waiting.pop()
        if path is not None and path not in found:
            found.add(path)
            waiting.extend(_imported(path))
    return found


@functools.cache
def _bytes_of(path: Path) -> bytes:
    """A source, read once for all kernels that depend on it."""
    return path.read_bytes()


# Names are found by a regular expression, because parsing every source is slow.
@functools.cache
def _imported(path: Path) -> tuple[Path | None, ...]:
    names = _names(_bytes_of(path).decode())
    return tuple(_path_of(_ROOT, name) for name in sorted(names))


def _names(source: str) -> set[str]:
    """Names of modules that a source imports, and of what may be modules of a package."""
    found: set[str] = set()
    for base, listed in _IMPORT.findall(source):
        parts = re.sub(r"#.*", "", listed).strip("() \n").split(",")
        names = [part.split()[0] for part in parts if part.strip()]
        found.update(names if not base else (base, *(f"{base}.{name}" for name in names)))
    return found


def _forget_old_caches(root: Path) -> None:
    """Keep the newest few directories, because every edit of a kernel begins another one."""
    if not root.exists():
        return
    caches = sorted(root.iterdir(), key=lambda path: path.stat().st_mtime)
    for directory in caches[:-_KEPT_CACHES]:
        shutil.rmtree(directory, ignore_errors=True)
