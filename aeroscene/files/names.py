"""File names from names that stand in files: ids of scenes, trials and cameras.

A scene, a recording or a campaign may come from anybody, so its names are data. A file that is
named after one of them lies in the folder that the user asked for, whatever the name says.
"""

from __future__ import annotations

import hashlib
import re

MOST_CHARACTERS = 120
"""Longest name, so that a suffix and a temporary prefix fit into the 255 bytes of file systems."""
_DIGEST_CHARACTERS = 8
_OTHERS = re.compile(r"[^A-Za-z0-9._-]+")


def file_name(name: str, otherwise: str = "scene") -> str:
    """A file name, without a suffix, for a name that came from a file.

    Args:
        name: Any text, also a path or one with control characters.
        otherwise: What a name without any usable character becomes.

    Returns:
        ASCII letters, digits, dots, dashes and underscores. It neither begins nor ends with a dot
        or a dash, so it is no parent folder, no hidden file and no option of a command. A name
        beyond `MOST_CHARACTERS` is cut, and ends with a digest of the whole.
    """
    clean = _OTHERS.sub("-", name).strip(".-") or otherwise
    if len(clean) <= MOST_CHARACTERS:
        return clean
    digest = hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()[:_DIGEST_CHARACTERS]
    return f"{clean[: MOST_CHARACTERS - _DIGEST_CHARACTERS - 1]}-{digest}"
