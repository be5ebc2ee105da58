"""Lidars described by files: TOML with all settings, or CSV with the angles of one scan alone.

A lidar differs from another by its pattern, rates, range and noise, so all of them are data; the
shipped ones are files like a user's own. Files come from elsewhere and are read with bounds on
length and numbers, so that a wrong one is refused with a line that says what would be valid, and
none takes the machine's memory. docs/sensors.md shows the forms and the sources of the shipped
figures.
"""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from aeroscene.files import UnpackError, read_bounded
from aeroscene.files.toml_fields import Fields
from aeroscene.files.toml_file import TomlFileError, read_toml
from autonomy.types import Vector3
from flightsim.lidars.pattern import (
    ListedPattern,
    Pattern,
    RosettePattern,
    directions_flu,
    spinning_pattern,
)

_SHIPPED = Path(__file__).parent / "shipped"
_COLUMNS = ["azimuth_deg", "elevation_deg"]
_MOST_SHOTS_HZ = 2_000_000  # bounds the rays cast in a simulated second
_MOST_CSV_BYTES = 8 << 20
"""Greatest length of a file of angles: 200,000 shots, as many as a scan of 10 Hz may have, with 40
bytes each."""
_MOST_LINES = 200_001  # the shots and a line of names
_MOST_HZ = 50.0
# A TOML file has exactly one of these.
_PATTERNS = ("spinning", "rosette", "angles")
_TURN_DEG = 360.0


class LidarError(ValueError):
    """There is no such lidar, or its file describes none; one line says what would be valid."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LidarCfg:
    """Settings of a lidar that the vehicle carries."""

    title: str
    pattern: Pattern
    """Directions of its shots, one after another."""
    scan_hz: float = 10.0
    """Scans per second."""
    range_m: tuple[float, float] = (0.1, 100.0)
    """Least and greatest distance that it measures."""
    noise_m: float = 0.02
    """Standard deviation of a distance."""
    position_flu_m: Vector3 = (0.0, 0.0, 0.1)
    """Place on the vehicle, from the centre of mass."""
    pitch_down_rad: float = 0.0
    """Angle by which its forward axis looks down."""

    @property
    def rotation_flu_from_lidar(self) -> Float[np.ndarray, "3 3"]:
        # Looking down is a positive turn about the left axis.
        """Its axes forward, left and up in the body frame, as columns."""
        s, c = math.sin(self.pitch_down_rad), math.cos(self.pitch_down_rad)
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def lidar_by_name(name: str) -> LidarCfg:
    """Return the lidar that ships under a name, or that of a file.

    Args:
        name: One of `LIDARS`, or the path of a file whose name ends in .toml or .csv.

    Returns:
        Its settings; a CSV file has those of `LidarCfg`'s defaults.

    Raises:
        LidarError: If there is none, or the file describes none; the line names file, field and
            value, and what would be valid.
    """
    if name in LIDARS:
        return LIDARS[name]
    path = Path(os.path.expanduser(name))  # noqa: PTH111 - pathlib's raises without one
    if path.suffix == ".toml":
        return _read(path)
    if path.suffix == ".csv":
        listed = ListedPattern(listed_flu=_read_angles(path))
        cfg = LidarCfg(title=path.stem, pattern=listed)
        if listed.shots_per_scan * cfg.scan_hz > _MOST_SHOTS_HZ:
            most = round(_MOST_SHOTS_HZ / cfg.scan_hz)
            raise LidarError(
                f"lidar {name!r} has {listed.shots_per_scan} shots; valid: up to {most}"
            )
        return cfg
    valid = ", ".join(LIDARS)
    raise LidarError(f"lidar {name!r} is unknown; valid: {valid}, or a file FILE.toml or FILE.csv")


def _read(path: Path) -> LidarCfg:
    file = f"lidar {str(path)!r}"
    try:
        plain = read_toml(path)
    except TomlFileError as error:
        raise LidarError(f"{file}: {error}") from None
    document = Fields(plain, file, error=LidarError)
    scan_hz = document.number("scan_hz", 0.1, _MOST_HZ, "Hz")
    mount = document.table("mount")
    x, y, z = mount.vector("position_m", 3, -5.0, 5.0, "m", default=(0.0, 0.0, 0.1))
    near_m, far_m = document.vector("range_m", 2, 0.0, 1000.0, "m")
    if not near_m < far_m:
        document.fail("range_m", f"is {[near_m, far_m]}; valid: the least distance first")
    cfg = LidarCfg(
        title=document.text("title"),
        pattern=_pattern(document, path.parent, scan_hz),
        scan_hz=scan_hz,
        range_m=(near_m, far_m),
        noise_m=document.number("noise_m", 0.0, 1.0, "m"),
        position_flu_m=(x, y, z),
        pitch_down_rad=math.radians(
            mount.number("pitch_down_deg", -90.0, 90.0, "degrees", default=0.0)
        ),
    )
    # After all fields have been read: a misspelt one is the one that is left over.
    mount.check_all_known()
    document.check_all_known()
    return cfg


def _pattern(document: Fields, folder: Path, scan_hz: float) -> Pattern:
    # Exactly one kind: with two it would be unclear which is meant.
    given = [name for name in _PATTERNS if document.has(name)]
    if len(given) != 1:
        document.fail(given[-1] if given else "spinning", _which_pattern(given))
    readers = {"spinning": _spinning, "rosette": _rosette, "angles": _angles}
    pattern = readers[given[0]](document, folder, scan_hz)
    if pattern.shots_per_scan * scan_hz > _MOST_SHOTS_HZ:
        document.fail(
            "scan_hz",
            f"is {scan_hz:g} with {pattern.shots_per_scan} shots in a scan; valid: up to "
            f"{_MOST_SHOTS_HZ} shots in a second",
        )
    return pattern


def _which_pattern(given: list[str]) -> str:
    valid = "one of [spinning], [rosette] and angles"
    return f"stands beside {given[0]}; valid: {valid}" if given else f"is missing; valid: {valid}"


def _spinning(document: Fields, _folder: Path, scan_hz: float) -> Pattern:
    table = document.table("spinning")
    n = table.count("beams", 1, 256)
    elevations = table.vector("elevations_deg", n, -90.0, 90.0, "degrees")
    step_deg = table.number("step_deg", 0.05, 90.0, "degrees")
    # A scan must end where the next one begins, which the tolerance of 1e-6 steps allows for
    # rounding.
    if abs(_TURN_DEG / step_deg - round(_TURN_DEG / step_deg)) > 1e-6:
        table.fail("step_deg", f"is {step_deg:g}; valid: a divisor of 360 degrees")
    firing_s = table.number("column_s", 0.0, 1.0, "s", default=0.0)
    # The head turns on while the beams of a column fire, but not into the next column.
    spread_deg = firing_s * scan_hz * _TURN_DEG
    if spread_deg > step_deg:
        longest_s = step_deg / (scan_hz * _TURN_DEG)
        table.fail("column_s", f"is {firing_s:g}; valid: 0 to {longest_s:.3g} s, that of a step")
    table.check_all_known()
    return spinning_pattern(
        np.radians(elevations), math.radians(step_deg), math.radians(spread_deg)
    )


def _rosette(document: Fields, _folder: Path, scan_hz: float) -> Pattern:
    table = document.table("rosette")
    first_rpm, second_rpm = table.vector("prisms_rpm", 2, -1e5, 1e5, "turns a minute")
    first_deg, second_deg = table.vector("deflections_deg", 2, 0.0, 45.0, "degrees")
    shots_hz = table.count("shots_hz", 1, _MOST_SHOTS_HZ)
    table.check_all_known()
    return RosettePattern(
        rates_hz=(first_rpm / 60.0, second_rpm / 60.0),
        deflections_rad=(math.radians(first_deg), math.radians(second_deg)),
        shots_per_scan=max(1, round(shots_hz / scan_hz)),
        shots_hz=float(shots_hz),
    )


def _angles(document: Fields, folder: Path, _scan_hz: float) -> Pattern:
    return ListedPattern(listed_flu=_read_angles(folder / document.text("angles", most=200)))


def _read_angles(path: Path) -> Float[np.ndarray, "n 3"]:
    """Return the directions in a CSV file, which has a line for each shot."""
    file = f"lidar {str(path)!r}"
    try:
        text = read_bounded(path, _MOST_CSV_BYTES).decode("utf-8")
        # Before parsing, which would take many times the file's memory.
        if (count := text.count("\n")) > _MOST_LINES:
            raise LidarError(f"{file} has {count} lines; valid: up to {_MOST_LINES}")
        lines = list(csv.reader(text.splitlines()))
    except OSError as error:
        raise LidarError(f"{file}: {error.strerror or error}; valid: a file") from None
    except UnpackError as error:
        raise LidarError(f"{file}: {error}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise LidarError(f"{file} is no CSV: {error}") from None
    if not lines or [name.strip() for name in lines[0]] != _COLUMNS or len(lines) == 1:
        first = ",".join(lines[0]) if lines else ""
        raise LidarError(
            f"{file}: line 1 is {first[:60]!r}; valid: {','.join(_COLUMNS)}, and a line for each "
            "shot below"
        )
    rows = np.array([_row(file, number, line) for number, line in enumerate(lines[1:], start=2)])
    azimuth_rad, elevation_rad = np.radians(rows).T
    return directions_flu(azimuth_rad, elevation_rad)


def _row(file: str, number: int, line: list[str]) -> tuple[float, float]:
    try:
        azimuth_deg, elevation_deg = (float(text) for text in line)
    except ValueError:
        azimuth_deg = elevation_deg = math.nan
    # NaN fails both comparisons, so it is refused too.
    if not (abs(azimuth_deg) <= _TURN_DEG and abs(elevation_deg) <= _TURN_DEG / 4):
        raise LidarError(
            f"{file}: line {number} is {','.join(line)[:60]!r}; valid: azimuth of -360 to 360 and "
            "elevation of -90 to 90 degrees"
        )
    return azimuth_deg, elevation_deg


_NAMES = ("vlp16", "mid40")
LIDARS: Mapping[str, LidarCfg] = MappingProxyType(
    {name: _read(_SHIPPED / f"{name}.toml") for name in _NAMES}
)
"""Lidars that ship, by name."""
