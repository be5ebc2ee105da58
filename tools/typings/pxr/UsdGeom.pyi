"""Made at run time from C++; the package ships no types."""

from typing import Any

def __getattr__(name: str) -> Any: ...
