"""Public names of a package that load what they stand for when they are first used (PEP 562).

`import aeroscene` stays a matter of milliseconds, and reading a scene loads no physics. A package
declares its names three times: as imports for type checkers, as `__all__` for readers, and with
their homes for this; `tests/test_public_names.py` holds the three together.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def public_names(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    Args:
        package: Name of the package, its `__name__`.
        homes: Names, separated by spaces, under the module that defines them.
    """
    home_of = {name: home for home, names in homes.items() for name in names.split()}

    def load(name: str) -> object:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *home_of})

    return load, names
