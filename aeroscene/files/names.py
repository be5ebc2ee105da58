"""File names from names inside of files: ids of scenes, trials and cameras.

A scene, a recording or a campaign may come from anybody, so its names are data. A file that is
named after one of them has to lie in the folder that the user asked for, whatever the name is.
"""

from __future__ import annotations

import hashlib
import re

MOST_CHARACTERS = 120
"""Longest name, so that a suffix and a temporary prefix fit into the 255 bytes of file systems."""
_DIGEST_CHARACTERS = 8
_OTHERS = re.compile(r"[^A-Za-z0-9._-]+")


def file_name(name: str, otherwise: str = "scene") -> str:
    """Make a file name, without a suffix, from a name that came from a file.

    Args:
        name: Any text, including paths and control characters.
        otherwise: Result for a name without any usable character.

    Returns:
        ASCII letters, digits, dots, dashes and underscores. It neither begins nor ends with a dot
        or a dash, so it is no parent folder, no hidden file and no option of a command. A name
        beyond `MOST_CHARACTERS` is cut, and ends with a digest of the whole.
    """
    clean = _OTHERS.sub("-", name).strip(".-") or otherwise
    if len(clean) <= MOST_CHARACTERS:
        return clean
    # Long names that differ only at their end get different files.
    digest = hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()[:_DIGEST_CHARACTERS]
    return f"{clean[: MOST_CHARACTERS - _DIGEST_CHARACTERS - 1]}-{digest}"
