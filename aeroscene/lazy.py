"""Public names of a package that load their modules when they are first used (PEP 562).

`import aeroscene` stays a matter of milliseconds, and reading a scene loads no physics. A package
states the origin of each name once, in imports under `if TYPE_CHECKING`, and lists the names for
readers in `__all__`. Type checkers and programs therefore read the same lines, and cannot disagree.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path


def public_names(
    package: str, file: str
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Make `__getattr__` and `__dir__` of a package from the imports that its type checker sees.

    Args:
        package: Name of the package, its `__name__`.
        file: Its source, its `__file__`, with one `if TYPE_CHECKING` of absolute imports. A `from
            other import *` stands for all names in the `__all__` of `other`. A package with such an
            import leaves its own `__all__` to `__getattr__`.

    Returns:
        The two functions, to be assigned at the top of the package.
    """

    @cache
    def homes() -> dict[str, str]:
        (branch,) = (
            node for node in ast.parse(Path(file).read_text()).body if isinstance(node, ast.If)
        )
        imports = (line for line in branch.body if isinstance(line, ast.ImportFrom))
        return {
            name: line.module or ""
            for line in imports
            for alias in line.names
            for name in _names(line.module or "", alias)
        }

    def load(name: str) -> object:
        if name == "__all__":
            return sorted(homes())
        if name not in homes():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        # Stored in the package: the next use finds the name without calling this function.
        value = getattr(import_module(homes()[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes()})

    return load, names


def _names(module: str, alias: ast.alias) -> list[str]:
    """Names that one item of an import stands for."""
    return list(import_module(module).__all__) if alias.name == "*" else [alias.name]
