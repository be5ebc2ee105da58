"""Public names of a package that load what they stand for when they are first used (PEP 562).

`import aeroscene` stays a matter of milliseconds, and reading a scene loads no physics. A package
says where each name comes from once, in imports under `if TYPE_CHECKING`, and names them for
readers in `__all__`.
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
    """`__getattr__` and `__dir__` of a package, from the imports that its type checker sees.

    Args:
        package: Name of the package, its `__name__`.
        file: Its source, its `__file__`, with one `if TYPE_CHECKING` of absolute imports. A
            `from other import *` stands for all that `other` names in its `__all__`. A package that
            has such an import leaves its own `__all__` to `__getattr__`.
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
        value = getattr(import_module(homes()[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes()})

    return load, names


def _names(module: str, alias: ast.alias) -> list[str]:
    """Names that one item of an import stands for."""
    return list(import_module(module).__all__) if alias.name == "*" else [alias.name]
