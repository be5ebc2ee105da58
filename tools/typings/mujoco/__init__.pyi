# MuJoCo's names come from compiled modules without annotations: anything may be asked of it.
from typing import Any

def __getattr__(name: str) -> Any: ...
