"""A disk that is full for one process, beyond so many bytes of a file."""

import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager

LIMITED = """
import resource, sys
limit = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
"""
"""Begins a program whose first argument is the number of bytes. Run it with `python -B`, for the
reason that `files_end_after` gives."""


@contextmanager
def files_end_after(n_bytes: int) -> Iterator[None]:
    """Let no file of this process grow beyond `n_bytes`.

    Bytecode is not kept meanwhile: Python would cut it short without an error, and every program
    that imports the module later would fail.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    keeps_no_bytecode = sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        sys.dont_write_bytecode = keeps_no_bytecode
