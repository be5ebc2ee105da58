"""Keys from passphrases, as ground stations derive them."""

from __future__ import annotations

import hashlib
from pathlib import Path

KEY_BYTES = 32
_LONGEST_BYTES = 1024
"""Longest file that is read: nobody types a longer passphrase."""


class SigningKeyError(ValueError):
    """A file holds no passphrase, or cannot be read."""


def key_of_passphrase(passphrase: str) -> bytes:
    """Return the key of 32 bytes that QGroundControl and MAVProxy derive: the SHA-256."""
    return hashlib.sha256(passphrase.encode()).digest()


def read_key(path: str | Path) -> bytes:
    """Return the key of the passphrase in a file's only line.

    Args:
        path: The file.

    Raises:
        SigningKeyError: If the file cannot be read, or does not hold one line of text.
    """
    try:
        with Path(path).open("rb") as file:
            # One byte more than is allowed, so that a longer file is noticed without reading all of
            # it.
            data = file.read(_LONGEST_BYTES + 1)
    except OSError as error:
        raise SigningKeyError(
            f"signing-key {str(path)!r} cannot be read: {error.strerror}"
        ) from error
    try:
        lines = data.decode().splitlines()
    except UnicodeDecodeError:
        lines = []
    if len(data) > _LONGEST_BYTES or len(lines) != 1 or not lines[0].strip():
        raise SigningKeyError(
            f"signing-key {str(path)!r} holds no passphrase; valid: a text file of one line, "
            f"at most {_LONGEST_BYTES} bytes"
        )
    return key_of_passphrase(lines[0])
