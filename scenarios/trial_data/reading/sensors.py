"""Lidar, optical flow and gauges of a recording, and the labels of its segments."""

from __future__ import annotations

import io
from collections.abc import Iterable

import numpy as np

from scenarios.recording import layout
from scenarios.recording.rows import RecordedRows
from scenarios.trial_data.reading.frames import Picture
from scenarios.trial_data.reading.states import SCALARS, Columns, pose_at, spread
from scenarios.trial_data.tables import GAUGES, QUATERNION

_POSE_US = 4_000
"""Time between two poses. A lidar ends its scans at its own rate, so a pose may be that old."""
_CONTEXT = "AnnotationContext:context"
_SEGMENTS = {"classes": layout.camera_classes, "instances": layout.camera_instances}


def scans(rows: RecordedRows) -> tuple[Columns, list[Picture]]:
    """Return the table of the lidar's scans, and their points as NumPy files."""
    found = sorted(rows.clouds(layout.LIDAR, "Points3D:positions"), key=lambda scan: scan[0])
    time_us = np.array([time for time, _ in found], dtype=np.int64)
    position_m, quat_wxyz = pose_at(rows, layout.VEHICLE, time_us, most_us=_POSE_US)
    # If a run was killed, the poses of its last second are missing.
    is_known = np.isfinite(position_m[:, 0])
    clouds = [points for (_, points), known in zip(found, is_known, strict=True) if known]
    files = [Picture(f"{number:06d}.points.npy", _npy(p)) for number, p in enumerate(clouds)]
    columns = {
        "scan": np.arange(len(clouds)),
        "time_us": time_us[is_known],
        "points": [len(points) for points in clouds],
        **spread("position", layout.AXES, "m", position_m[is_known]),
        **spread("attitude", QUATERNION, "", quat_wxyz[is_known]),
        "points_file": [each.file for each in files],
    }
    return columns, files


def _npy(points_m: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, points_m.astype(np.float32))
    return file.getvalue()


def optical_flow(rows: RecordedRows) -> Columns:
    """Return the samples of the sensor of optical flow."""
    parts = layout.OPTICAL_FLOW_PARTS
    time_us, values = rows.vectors(layout.OPTICAL_FLOW, SCALARS, len(parts))
    columns = dict(zip(parts, values.T, strict=True))
    whole = {name: columns[name].astype(np.int64) for name in ("integration_us", "quality")}
    return {"time_us": time_us, **columns, **whole}


def gauges(rows: RecordedRows) -> Columns:
    """Values that are sampled at 10 Hz, up to the last time at which all of them are known."""
    found = {name: rows.vectors(entity, SCALARS, 1) for name, (entity, _) in GAUGES.items()}
    times = [time_us for time_us, _ in found.values() if len(time_us)]
    # The shortest: a torn recording may lack the last rows of some.
    time_us = min(times, key=len) if times else np.zeros(0, dtype=np.int64)
    n = len(time_us)
    columns = {
        name: values[:n, 0] if len(values) else np.full(n, np.nan)
        for name, (_, values) in found.items()
    }
    return {"time_us": time_us, **columns}


def labels(rows: RecordedRows, cameras: Iterable[str]) -> Columns:
    """The meaning of the numbers in images of classes and of instances; all cameras agree."""
    found: dict[tuple[str, int], str] = {}
    for camera in cameras:
        for image, entity in _SEGMENTS.items():
            for _, (context, *_) in rows.rows(entity(camera), _CONTEXT):
                for entry in context:
                    label = entry["class_description"]["info"]["label"]
                    found[image, entry["class_id"]] = label
    keys = sorted(found)
    return {
        "image": [image for image, _ in keys],
        "number": [number for _, number in keys],
        "name": [found[key] for key in keys],
    }
