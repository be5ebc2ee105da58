"""Public names of a package that load what they stand for when they are first used (PEP 562).

`import aeroscene` stays a matter of milliseconds, and reading a scene loads no physics. A package
says where each name comes from once, in imports under `if TYPE_CHECKING`, and names them for
readers in `__all__`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path


def public_names(
    package: str, file: str
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package, from the imports that its type checker sees.

    Args:
        package: Name of the package, its `__name__`.
        file: Its source, its `__file__`, with one `if TYPE_CHECKING` of absolute imports.
    """
    (branch,) = (
        node for node in ast.parse(Path(file).read_text()).body if isinstance(node, ast.If)
    )
    imports = (line for line in branch.body if isinstance(line, ast.ImportFrom))
    home_of = {name.name: line.module or "" for line in imports for name in line.names}

    def load(name: str) -> object:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *home_of})

    return load, names
