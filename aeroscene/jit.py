"""Compiled kernels whose kept machine code is never stale.

numba's own cache looks at the file of the compiled function only: after an edit of a function that
lives in another file it serves the old code. So each kernel's code is kept in a folder that is
named by a hash of its module and of all modules of the same package that this one imports.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numba
import platformdirs
from numba.core import config

_config: Any = config  # its names are made at run time
_F = TypeVar("_F", bound=Callable[..., Any])


def kernel(function: _F) -> _F:
    """Compile a function on its first call and keep the code; numba's settings stay as they are."""
    compiler: Any = numba.njit  # its annotations leave options out
    before, _config.CACHE_DIR = _config.CACHE_DIR, str(_folder(function.__module__))
    try:
        return compiler(cache=True, error_model="numpy")(function)
    finally:
        _config.CACHE_DIR = before


@functools.cache
def _folder(module: str) -> Path:
    """Where the code of a module's kernels is kept."""
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
    cache = Path(platformdirs.user_cache_dir("aeroscene"))
    return cache / "kernels" / module / digest.hexdigest()


def _imported(source: bytes) -> Iterator[str]:
    """Names that may be modules."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
