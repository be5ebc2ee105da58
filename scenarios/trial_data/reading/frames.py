"""Camera frames of a recording: encoded images with poses and lenses.

Recordings hold the vehicle's pose and each camera's mount; a frame's pose follows from both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from aeroscene.files.names import file_name
from scenarios.recording import layout
from scenarios.recording.frames import encode_png
from scenarios.recording.rows import RecordedRows
from scenarios.trial_data.reading.states import TRANSLATION, Columns, pose_at, spread
from scenarios.trial_data.tables import QUATERNION

IMAGES = {"rgb": "jpg", "depth": "png", "classes": "png", "instances": "png"}
"""Kinds of images of a frame, and the suffix of their files."""


class Mount(NamedTuple):
    """Place of a camera on its vehicle, and its lens."""

    position_flu_m: np.ndarray
    """Shape (3,)."""
    quat_flu_from_optical_wxyz: np.ndarray
    """Shape (4,)."""
    focal_px: tuple[float, float]
    centre_px: tuple[float, float]
    size_px: tuple[int, int]
    """Width and height."""


class Picture(NamedTuple):
    """An encoded image and its name."""

    file: str
    data: bytes


def read_mounts(rows: RecordedRows) -> dict[str, Mount]:
    """Return the cameras that have frames, by their names."""
    found: dict[str, Mount] = {}
    prefix = layout.camera("")
    for entity in rows.entities:
        lens = rows.rows(entity, "Pinhole:image_from_camera")
        turns = rows.rows(entity, "Transform3D:mat3x3")
        if not entity.startswith(prefix) or not lens:
            continue
        if not turns:
            # Recordings of earlier versions lack the mounts of the cameras that look for traffic.
            rows.others.add(entity)
            continue
        matrix = np.array(lens[-1][1][0])
        width, height = rows.rows(entity, "Pinhole:resolution")[-1][1][0]
        # rerun keeps matrices column by column.
        turn = np.array(turns[-1][1][0]).reshape(3, 3).T
        found[entity.removeprefix(prefix)] = Mount(
            position_flu_m=np.array(rows.rows(entity, TRANSLATION)[-1][1][0]),
            quat_flu_from_optical_wxyz=Rotation.from_matrix(turn).as_quat(scalar_first=True),
            focal_px=(matrix[0], matrix[4]),
            centre_px=(matrix[6], matrix[7]),
            size_px=(round(width), round(height)),
        )
    return found


def read_frames(rows: RecordedRows, mounts: Mapping[str, Mount]) -> tuple[Columns, list[Picture]]:
    """Return the table of the frames, and their images."""
    # Time and camera alone: the encoded images cannot be ordered.
    seen = sorted(_images(rows, mounts), key=lambda image: image[:2])
    time_us = np.array([image[0] for image in seen], dtype=np.int64)
    position_m, quat_wxyz = pose_at(rows, layout.VEHICLE, time_us)
    # If a run was killed, the poses of its last second are missing.
    is_known = np.isfinite(position_m[:, 0])
    seen = [image for image, known in zip(seen, is_known, strict=True) if known]
    pictures: list[Picture] = []
    files: dict[str, list[str | None]] = {kind: [] for kind in IMAGES}
    for number, (_, camera, data) in enumerate(seen):
        for kind, encoded in data.items():
            name = f"{number:06d}_{file_name(camera, 'camera')}.{kind}.{IMAGES[kind]}"
            files[kind].append(None if encoded is None else name)
            if encoded is not None:
                pictures.append(Picture(name, encoded))
    cameras = [image[1] for image in seen]
    poses = _camera_poses(position_m[is_known], quat_wxyz[is_known], [mounts[c] for c in cameras])
    columns = {
        "frame": np.arange(len(seen)),
        "time_us": time_us[is_known],
        "camera": cameras,
        **_lenses([mounts[camera] for camera in cameras]),
        **spread("position", layout.AXES, "m", poses[0]),
        **spread("attitude", QUATERNION, "", poses[1]),
        **{f"{kind}_file": names for kind, names in files.items()},
    }
    return columns, pictures


def _images(
    rows: RecordedRows, mounts: Mapping[str, Mount]
) -> Iterator[tuple[int, str, dict[str, bytes | None]]]:
    """Yield time, camera and encoded images of each frame by kind; None if a kind is missing."""
    for camera in mounts:
        found = {
            "rgb": dict(rows.blobs(layout.camera_rgb(camera), "EncodedImage:blob")),
            "depth": dict(rows.blobs(layout.camera_depth(camera), "EncodedDepthImage:blob")),
            "classes": dict(_segments(rows, layout.camera_classes(camera))),
            "instances": dict(_segments(rows, layout.camera_instances(camera))),
        }
        for time_us in sorted(set().union(*found.values())):
            yield time_us, camera, {kind: images.get(time_us) for kind, images in found.items()}


def _segments(rows: RecordedRows, entity: str) -> Iterator[tuple[int, bytes]]:
    """Yield time and PNG of each image of segments, which recordings keep as plain numbers."""
    formats = rows.rows(entity, "SegmentationImage:format")
    blobs = rows.blobs(entity, "SegmentationImage:buffer")
    for (time_us, data), (_, (shape, *_)) in zip(blobs, formats, strict=True):
        size = (shape["height"], shape["width"])
        # Classes have one byte a pixel, objects two.
        kind = np.uint8 if len(data) == size[0] * size[1] else np.uint16
        yield time_us, encode_png(np.frombuffer(data, kind).reshape(size))


def _camera_poses(
    position_m: Float[np.ndarray, "n 3"], quat_wxyz: Float[np.ndarray, "n 4"], mounts: list[Mount]
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 4"]]:
    """Return positions and attitudes of cameras on a vehicle of these poses."""
    if not mounts:
        return position_m, quat_wxyz
    enu_from_flu = Rotation.from_quat(quat_wxyz, scalar_first=True)
    at_flu_m = np.array([mount.position_flu_m for mount in mounts])
    turns = Rotation.from_quat(
        np.array([mount.quat_flu_from_optical_wxyz for mount in mounts]), scalar_first=True
    )
    quat = (enu_from_flu * turns).as_quat(scalar_first=True)
    return position_m + enu_from_flu.apply(at_flu_m), quat


def _lenses(mounts: list[Mount]) -> Columns:
    size_px = np.array([mount.size_px for mount in mounts], dtype=np.int64).reshape(-1, 2)
    focal_px = np.array([mount.focal_px for mount in mounts]).reshape(-1, 2)
    centre_px = np.array([mount.centre_px for mount in mounts]).reshape(-1, 2)
    return {
        "width_px": size_px[:, 0],
        "height_px": size_px[:, 1],
        **spread("focal", ("x", "y"), "px", focal_px),
        **spread("centre", ("x", "y"), "px", centre_px),
    }
