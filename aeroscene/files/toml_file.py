"""TOML files of others, read within bounds."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from aeroscene.files import UnpackError, read_bounded
from aeroscene.files.bounds import MOST_CONFIG_BYTES

_NUMBER = re.compile(rb"(?<![0-9.])[0-9]+\.[0-9]+(?![0-9.])")
_MOST_DOTS = 200
"""Most dots of a line, without those of its numbers: tomllib takes gigabytes for a.a.a... and so
on.
"""


class TomlFileError(ValueError):
    """A file that is no TOML; the message says why, and what would be valid."""


def read_toml(path: Path) -> dict[str, Any]:
    """Read the document in a TOML file.

    Args:
        path: File.

    Raises:
        TomlFileError: If it cannot be read, is too large, nested too deeply, or no TOML.
    """
    try:
        data = read_bounded(path, MOST_CONFIG_BYTES)
        _require_few_dots(data)
        return tomllib.loads(data.decode())
    except OSError as error:
        raise TomlFileError(f"{error.strerror or error}; valid: a file") from None
    except UnpackError as error:
        raise TomlFileError(str(error)) from None
    except TomlFileError:
        raise
    except RecursionError:
        raise TomlFileError("it is nested too deeply; valid: tables of fields") from None
    except ValueError as error:  # of tomllib, of UTF-8, or of integers with thousands of digits
        raise TomlFileError(f"it is no TOML: {error}") from None


def _require_few_dots(data: bytes) -> None:
    if any(line.count(b".") > _MOST_DOTS for line in _NUMBER.sub(b"", data).split(b"\n")):
        raise TomlFileError("it is nested too deeply; valid: tables of fields")
