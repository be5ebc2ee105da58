"""Parts that every sensor has: a record in the plant's, a clock, a stream of noise and a reading.

A sensor is data, not a class with methods: the compiled kernel can read a record but cannot call a
Python object. Each sensor module ends in a `Sensor` that names its record fields, its configuration
and its random stream. `flightsim.plant.sensing` lists all sensors and calls their kernels.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np

from autonomy.jit import kernel
from autonomy.types import LEVEL, ZERO3, Quaternion, Vector3
from flightsim.environment.magnetic_field import FIELD_ENU_UT
from flightsim.sensors.failure import FAILURE_FIELDS, LATE_S, N_CHANNELS, N_KEPT, is_heard

_CODES = {"f8": "d", "i8": "q"}
"""Format characters of the `struct` module for the types of record fields."""
_CLOCK_FIELDS = (
    ("tick", "i8"),  # tick for which the last sample is valid, -1 before the first
    ("rate_hz", "i8"),
    ("period_ticks", "i8"),
    ("is_enabled", "i8"),
    ("is_replaced", "i8"),  # 1 if a client sends this instead (`flightsim.plant.external_aids`)
    ("first_normal", "i8"),  # where its block begins among the plant's normals
    ("n_normals", "i8"),  # standard normals that a sample takes
    *FAILURE_FIELDS,
)


@dataclass(frozen=True, kw_only=True, slots=True)
class SensorStart:
    """State of the vehicle and the world when a sensor is switched on."""

    tick_hz: int
    """Control ticks a second."""
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    """Random stream of errors that are drawn once for the whole flight."""
    position_enu_m: Vector3 | np.ndarray = ZERO3
    velocity_enu_mps: Vector3 | np.ndarray = ZERO3
    quat_wxyz: Quaternion | np.ndarray = LEVEL
    """Attitude, body FLU to world ENU."""
    altitude_m: float = 0.0
    """Altitude of the scene's z = 0 above mean sea level."""
    field_enu_ut: Vector3 = FIELD_ENU_UT
    """Magnetic field of the Earth at the scene, uT."""
    amperes_per_cubed_speed: float = 0.0
    """Ratio of the motors' current to the sum of their cubed speeds, A s^3/rad^3."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Sensor:
    """Description of one kind of sensor: how to build, read, fail and plot it."""

    name: str
    """Name in the plant's record, in `plant.sensors` and in calls that switch it off and on."""
    setting: str
    """Field of `PlantCfg` that configures the sensor."""
    fields: Sequence[tuple[Any, ...]]
    """Fields of the sensor's record in addition to the clock, as for `numpy.dtype`."""
    n_normals: int
    """Number of standard normals that a sample takes."""
    stream: int
    """Number of the random stream of noise. It never changes, because then all its errors would
    change; a new sensor takes the next free number."""
    start_stream: int | None = None
    """Number of the random stream for errors drawn once; None for a branch of `stream`."""
    configure: Callable[[np.void, Any, SensorStart], None]
    """Completes a new record, in which fields that the configuration has by the same name are
    already filled and all others are zero."""
    read: Callable[[np.void, int], Any] = lambda r, _: r
    """Returns the latest sample, from the record and the length of a control tick in us; see
    `reader`."""
    grades: Mapping[str, Any] | None = None
    """Configurations by name, for a sensor whose setting is a name such as "rtk"."""
    wrong: Sequence[float] = ()
    """Constant that the failure WRONG adds to each number of a sample, see
    `flightsim.sensors.failure`."""
    garbage: Sequence[float] = ()
    """Standard deviation of each number under the failure GARBAGE."""
    gauge: tuple[str, Callable[[Any], float]] | None = None
    """Legend of a plot in recordings, and the function that gives its value from a reading."""

    @property
    def dtype(self) -> np.dtype:
        """Type of the sensor's record: the clock, then `fields`."""
        return np.dtype([*_CLOCK_FIELDS, *self.fields], align=True)

    @property
    def start_streams(self) -> tuple[int, ...]:
        """Key of the random stream for errors drawn once: its own, or a branch of `stream`."""
        return (self.stream, 0) if self.start_stream is None else (self.start_stream,)

    def cfg(self, plant_cfg: Any) -> Any:
        """Return the configuration of this sensor from a `PlantCfg`."""
        setting = getattr(plant_cfg, self.setting)
        return self.grades[setting] if self.grades else setting

    def new(self, cfg: Any, start: SensorStart) -> np.ndarray:
        """Return the record of a sensor before its first sample, in an array of shape (1,).

        Args:
            cfg: Settings of the sensor; fields with a name of the record are copied into it.
            start: Facts that a sensor begins with, such as the rate of the ticks.
        """
        records = np.zeros(1, self.dtype)
        r: np.void = records[0]
        # A configuration without `rate_hz`, such as the IMU's, measures at every tick.
        r["rate_hz"] = start.tick_hz
        for name in records.dtype.names or ():
            if hasattr(cfg, name):
                r[name] = getattr(cfg, name)
        r["period_ticks"] = start.tick_hz // r["rate_hz"]
        r["n_normals"] = self.n_normals
        r["is_enabled"] = 1
        r["tick"] = -1
        r["n_late"] = min(round(LATE_S * r["rate_hz"]), N_KEPT - 1)
        for name, numbers in (("wrong", self.wrong), ("garbage", self.garbage)):
            r[name] = (*numbers, *(0.0,) * (N_CHANNELS - len(numbers)))
        self.configure(r, cfg, start)
        return records


@kernel
def is_due(r: np.record, tick: int) -> bool:
    """Return true if a sensor measures and sends at this tick.

    Args:
        r: Record of the sensor; it sends nothing while it is off, failed or replaced from outside.
        tick: Number of the control tick.
    """
    is_on = r.is_enabled == 1 and r.is_replaced == 0
    return is_on and tick % r.period_ticks == 0 and is_heard(r, 0, tick)


@kernel
def has_arrived(r: np.record, tick: int) -> bool:
    """Return true if the last sample of a sensor with a delay arrives at this tick.

    Args:
        r: Record of the sensor; its `tick` is that of the sample, -1 before the first.
        tick: Number of the control tick.
    """
    is_on = r.is_enabled == 1 and r.is_replaced == 0
    return is_on and r.tick >= 0 and tick == r.tick + r.delay_ticks


@kernel
def noise(r: np.record, tick: int, normals: np.ndarray) -> np.ndarray:
    """Return the standard normals for the sample of this tick, from the block of this second.

    The block is laid out by sample number, not by drawing order. A sensor that skips samples,
    because it is off or has no signal, therefore has the same noise afterwards.
    """
    first = r.first_normal + (tick - 1) // r.period_ticks % r.rate_hz * r.n_normals
    return normals[first : first + r.n_normals]


def reader(reading: Any) -> Callable[[np.void, int], Any]:
    """Return a function that reads a record into a named tuple.

    Args:
        reading: Named tuple class whose first field is `time_us`; the record has all others.
    """
    first, *names = reading._fields
    assert first == "time_us", f"{reading.__name__} begins with {first}"
    read_numbers = numbers("tick", *names)

    def read(r: np.void, tick_us: int) -> Any:
        tick, *values = read_numbers(r)
        # The tick is -1 before the first sample; readings show time 0 then.
        return reading(max(0, tick) * tick_us, *values)

    return read


def numbers(*names: str) -> Callable[[np.void], tuple[Any, ...]]:
    """Return a function that reads these fields of a record as plain numbers and tuples.

    It unpacks the bytes with `struct`, which is far faster than numpy's access to one field after
    another. One function serves records of one dtype only.
    """
    unpack: Callable[[Any], tuple[Any, ...]] | None = None
    choose: Callable[[Any], tuple[Any, ...]] = itemgetter(0)

    def read(r: np.void) -> tuple[Any, ...]:
        nonlocal unpack, choose
        # The layout is known only from the first record; it is the same for all later ones.
        if unpack is None:
            unpack, choose = _unpacker(r.dtype, names)
        return choose(unpack(r))

    return read


def _unpacker(
    dtype: Any, names: Sequence[str]
) -> tuple[Callable[[Any], tuple[Any, ...]], Callable[[Any], tuple[Any, ...]]]:
    """Return a function that unpacks fields from bytes, and one that sorts them by the names."""
    offsets = {name: (dtype.fields or {})[name][1] for name in names}
    codes, found, n = "=", {}, 0
    # `struct` reads forward only: fields go by their offset, with pad bytes ("x") between them.
    for name in sorted(names, key=lambda name: offsets[name]):
        size = math.prod(dtype[name].shape)
        codes += (
            f"{offsets[name] - struct.calcsize(codes)}x{size}{_CODES[dtype[name].base.str[1:]]}"
        )
        found[name] = slice(n, n + size) if dtype[name].shape else n
        n += size
    return struct.Struct(codes).unpack_from, itemgetter(*(found[name] for name in names))


class NormalStream:
    """Standard normals of one second, drawn in one call.

    In a block a number costs 11 ns, alone far more. Every sensor has its own stream, so that
    another rate or number of draws in one sensor leaves the errors of the others unchanged.
    """

    def __init__(self, seed: np.random.SeedSequence, block: np.ndarray) -> None:
        self._generator = np.random.default_rng(seed)
        self._block = block

    def draw(self) -> None:
        """Fill the block with new numbers; call it once a second."""
        self._generator.standard_normal(out=self._block)
