"""Layout files as text and JSON: plain or gzip, whole or in lines, faults with their place.

A file of lines is read line by line, so that it takes the memory of one scene only.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aeroscene.files import UnpackError, pieces
from aeroscene.files.bounds import MOST_JSON_BYTES, excess
from aeroscene.layouts.document import LayoutError

MOST_BYTES = 32 << 20
"""Largest file of one layout, unpacked: the largest houses with their meshes."""
MOST_LINES_BYTES = 256 << 20
"""Largest file of many layouts, unpacked; ProcTHOR's 12,000 houses take half of it."""
MOST_LINES = 200_000
"""Most lines of such a file, including blank ones."""


def source_name(path: Path) -> str:
    """Name of a file in error messages."""
    return f"layout file {str(path)!r}"


def read_bytes(path: Path) -> bytes:
    """Read a file of one layout, unpacked if it is gzip, whatever its name.

    Raises:
        LayoutError: If it cannot be read, is cut short, too large or empty.
    """
    content = io.BytesIO()
    content.writelines(_pieces(path, MOST_BYTES))
    data = content.getvalue()
    if not data.strip():
        raise LayoutError(f"{source_name(path)} is empty; valid: a scene in JSON")
    return data


def _pieces(path: Path, most_bytes: int) -> Iterator[bytes]:
    where = source_name(path)
    try:
        yield from pieces(path, most_bytes)
    except UnpackError as error:
        raise LayoutError(f"{where}: {error}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise LayoutError(
            f"{where} cannot be read ({reason.lower()}); valid: a JSON file"
        ) from None


def decode_text(data: bytes, where: str, first_line: int = 1) -> str:
    """Decode UTF-8 text, with or without a byte order mark.

    Args:
        data: Bytes.
        where: Name of the file in errors.
        first_line: Number of the first line in the file.

    Raises:
        LayoutError: If a byte is no UTF-8; it names the first one.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + first_line
        raise LayoutError(
            f"{where} line {line}: byte {error.start} is no UTF-8; valid: JSON in UTF-8"
        ) from None


def parse_json(data: bytes, where: str, first_line: int = 1) -> Any:
    """Parse a JSON text; NaN passes here and is refused by the field that holds it.

    Args:
        data: UTF-8 text.
        where: Name of the file in errors.
        first_line: Number of the first line in the file.

    Raises:
        LayoutError: If the text ends too early, is malformed, or exceeds a bound; it names the
            line.
    """
    if (fault := excess(data)) is not None:
        raise LayoutError(f"{where} line {first_line}: it {fault}")
    text = decode_text(data, where, first_line)
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        line = first_line + error.lineno - 1
        is_cut = error.pos >= len(text.rstrip())
        fault = "cut short" if is_cut or "Unterminated" in error.msg else "malformed"
        raise LayoutError(
            f"{where} line {line}: JSON is {fault} ({error.msg.lower()} at column {error.colno}); "
            "valid: a whole JSON text"
        ) from None
    except RecursionError:
        raise LayoutError(f"{where}: JSON is nested too deeply; valid: a scene") from None
    except ValueError as error:  # Integers of thousands of digits.
        raise LayoutError(f"{where}: a number is too long ({error}); valid: a scene") from None


def text_lines(path: Path) -> Iterator[tuple[int, bytes, LayoutError | None]]:
    """Number and text of every line that is not blank; a line that is too long carries its error.

    Raises:
        LayoutError: If the file cannot be read, is cut short, too large or empty.
    """
    where = source_name(path)
    # Unpacked twice, so that a file with damage further down is refused before its first scene.
    is_empty = True
    for piece in _pieces(path, MOST_LINES_BYTES):
        is_empty = is_empty and not piece.strip()
    if is_empty:
        raise LayoutError(f"{where} is empty; valid: a scene in JSON")
    for number, line in enumerate(_lines(path), 1):
        if number > MOST_LINES:
            raise LayoutError(f"{where} has more than {MOST_LINES} lines; valid: at most that")
        if len(line) > MOST_JSON_BYTES:
            most = MOST_JSON_BYTES >> 20
            message = f"{where} line {number} holds more than {most} MiB; valid: at most that"
            yield number, b"", LayoutError(message)
        elif line.strip():
            yield number, line, None


def _lines(path: Path) -> Iterator[bytes]:
    """Lines of a file; a line that is too long is cut where its length is evident."""
    line = bytearray()
    for piece in _pieces(path, MOST_LINES_BYTES):
        first, *others = piece.split(b"\n")
        # One byte more than allowed shows that the line is too long; the rest is not kept.
        line += first[: MOST_JSON_BYTES + 1 - len(line)]
        for other in others:
            yield bytes(line)
            line = bytearray(other)
    yield bytes(line)
