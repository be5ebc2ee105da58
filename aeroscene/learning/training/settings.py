"""Configuration files: TOML whose sections change some fields of a preset.

    [training]
    batch_size = 32
    learning_rate = 5e-4

Every section is a frozen dataclass. Fields that the file does not name stay as the preset has them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from aeroscene.files.toml_file import TomlFileError, read_toml
from aeroscene.learning.training.config import TrainingError

Section = TypeVar("Section")


def read_settings(path: Path, sections: Mapping[str, Any]) -> dict[str, Any]:
    """Return sections as a TOML file changes them.

    Raises:
        TrainingError: If the file cannot be read, or a name or value in it is not valid.
    """
    where = f"config {str(path)!r}"
    try:
        document = read_toml(path)
    except TomlFileError as error:
        raise TrainingError(f"{where}: {error}") from None
    try:
        return changed(sections, document)
    except TrainingError as error:
        raise error.within(where) from None


def changed(sections: Mapping[str, Any], document: Mapping[str, Any]) -> dict[str, Any]:
    """Return sections with new values of some fields.

    Args:
        sections: Sections by name.
        document: New values, by section and field.

    Raises:
        TrainingError: If a section or field does not exist, or a value is out of range.
    """
    result = dict(sections)
    for name, values in document.items():
        if name not in sections:
            raise TrainingError(f"section [{name}] is unknown; valid: {', '.join(sections)}")
        # Here a field stands outside of any section.
        if not isinstance(values, dict):
            raise TrainingError(f"{name} is {values!r}; valid: a section [{name}] with fields")
        result[name] = section_with(sections[name], values, name)
    return result


def section_with(section: Section, values: Mapping[str, Any], name: str) -> Section:
    """Return a section with new values of some fields.

    Args:
        section: A frozen dataclass.
        values: New values by field.
        name: Name of the section, for messages.

    Raises:
        TrainingError: If a field does not exist, or a value has another type or is out of range.
    """
    # Through plain data, so that msgspec checks types as it does for checkpoints.
    plain = section_to_plain(section)
    for key in values:
        if key not in plain:
            raise TrainingError(f"{name}.{key} is unknown; valid: {', '.join(plain)}")
    return section_from_plain(type(section), plain | dict(values), name)


def section_from_plain(kind: type[Section], plain: Mapping[str, Any], name: str) -> Section:
    """Return a section from the plain data of `section_to_plain`.

    Raises:
        TrainingError: If a value has another type or is out of range.
    """
    try:
        return msgspec.convert(dict(plain), kind)
    except msgspec.ValidationError as error:
        raise TrainingError(f"[{name}] {_without_path(str(error))}") from None


def section_to_plain(section: Any) -> dict[str, Any]:
    """Return a section as numbers, texts, lists and dictionaries."""
    return msgspec.to_builtins(asdict(section))


def _without_path(message: str) -> str:
    """Return a message of msgspec with its path `$.field` as a field's name."""
    text, _, path = message.partition(" - at `$.")
    return f"{path.rstrip('`')}: {text}" if path else message
