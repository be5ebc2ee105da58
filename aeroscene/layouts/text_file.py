"""Layout files as text and JSON: plain or gzip, whole or in lines, faults with their place."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aeroscene.files import UnpackError, read_bounded
from aeroscene.layouts.document import LayoutError


def source_name(path: Path) -> str:
    """Name of a file in error messages."""
    return f"layout file {str(path)!r}"


def read_bytes(path: Path) -> bytes:
    """The content of a file, unpacked where it is gzip, whatever its name.

    Raises:
        LayoutError: If it cannot be read, is cut short, too large or empty.
    """
    where = source_name(path)
    try:
        data = read_bounded(path)
    except UnpackError as error:
        raise LayoutError(f"{where}: {error}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise LayoutError(
            f"{where} cannot be read ({reason.lower()}), valid: a JSON file"
        ) from None
    if not data.strip():
        raise LayoutError(f"{where} is empty, valid: a scene in JSON")
    return data


def decode_text(data: bytes, where: str) -> str:
    """UTF-8 text.

    Raises:
        LayoutError: Naming the first byte that is none.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise LayoutError(
            f"{where} line {line}: byte {error.start} is no UTF-8, valid: JSON in UTF-8"
        ) from None


def parse_json(text: str, where: str, first_line: int = 1) -> Any:
    """The value of a JSON text; NaN passes here and is refused by the field that holds it.

    Raises:
        LayoutError: Naming the line where it ends too early or is malformed.
    """
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        line = first_line + error.lineno - 1
        is_cut = error.pos >= len(text.rstrip())
        fault = "cut short" if is_cut or "Unterminated" in error.msg else "malformed"
        raise LayoutError(
            f"{where} line {line}: JSON is {fault} ({error.msg.lower()} at column {error.colno}), "
            "valid: a whole JSON text"
        ) from None
    except RecursionError:
        raise LayoutError(f"{where}: JSON is nested too deeply, valid: a scene") from None
    except ValueError as error:  # Integers of thousands of digits.
        raise LayoutError(f"{where}: a number is too long ({error}), valid: a scene") from None


def read_json(path: Path) -> Any:
    """The one JSON value of a file."""
    where = source_name(path)
    return parse_json(decode_text(read_bytes(path), where), where)


def text_lines(path: Path) -> Iterator[tuple[int, str, LayoutError | None]]:
    """Number and text of every line that is not blank; a line that is no text carries its error."""
    where = source_name(path)
    for number, line in enumerate(read_bytes(path).split(b"\n"), 1):
        if not line.strip():
            continue
        try:
            yield number, decode_text(line, where), None
        except LayoutError:
            message = f"{where} line {number}: not UTF-8, valid: JSON in UTF-8"
            yield number, "", LayoutError(message)
