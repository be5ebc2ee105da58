"""Messages of the camera: identity, settings, storage, and photographs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flightsim.environment.date import EPOCH_US
from flightsim.frames import swap_quat_enu_flu_ned_frd
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.view import VehicleView
from flightsim.payload import Payload
from flightsim.payload.camera import CameraMode
from flightsim.payload.card import CAPACITY_BYTES
from flightsim.payload.lens import FOCAL_LENGTH_MM, HORIZONTAL_FOV_RAD, SENSOR_MM, SIZES_PX
from flightsim.payload.photograph import Photograph
from flightsim.payload.video import BITRATE_BPS, RATE_HZ, VideoStream

_CAMERA_INFORMATION = layout("CAMERA_INFORMATION")
_CAMERA_SETTINGS = layout("CAMERA_SETTINGS")
_STORAGE_INFORMATION = layout("STORAGE_INFORMATION")
_CAPTURE_STATUS = layout("CAMERA_CAPTURE_STATUS")
_IMAGE_CAPTURED = layout("CAMERA_IMAGE_CAPTURED")
_STREAM_INFORMATION = layout("VIDEO_STREAM_INFORMATION")
_STREAM_STATUS = layout("VIDEO_STREAM_STATUS")

STREAM_ID = 1
STORAGE_ID = 1
_FLAGS = (
    mav.CAMERA_CAP_FLAGS_CAPTURE_IMAGE
    | mav.CAMERA_CAP_FLAGS_HAS_MODES
    | mav.CAMERA_CAP_FLAGS_CAN_CAPTURE_IMAGE_IN_VIDEO_MODE
)
_FILM_FLAGS = (
    mav.CAMERA_CAP_FLAGS_CAPTURE_VIDEO | mav.CAMERA_CAP_FLAGS_CAN_CAPTURE_VIDEO_IN_IMAGE_MODE
)
_VERSION = 1
_MIB = 1 << 20
_IDLE, _IN_SERIES = 0, 2
"""Values of image_status: without a series, and between the pictures of one."""


class CameraMessages:
    """Packs the camera's messages; those of a stream only if there is one."""

    def __init__(self, view: VehicleView, payload: Payload, gimbal_device_id: int) -> None:
        self._view = view
        self._payload = payload
        self._camera = payload.camera
        self._gimbal_device_id = gimbal_device_id
        self.producers: dict[str, Callable[[], bytes | None]] = {
            "CAMERA_INFORMATION": self._information,
            "CAMERA_SETTINGS": self._settings,
            "STORAGE_INFORMATION": self._storage,
            "CAMERA_CAPTURE_STATUS": self._capture_status,
            "CAMERA_IMAGE_CAPTURED": self._latest,
        }
        if (video := payload.video) is not None:
            self.producers["VIDEO_STREAM_INFORMATION"] = lambda: self._stream_information(video)
            self.producers["VIDEO_STREAM_STATUS"] = lambda: self._stream_status(video)

    def captured(self, p: Photograph) -> bytes:
        """Return CAMERA_IMAGE_CAPTURED of a photograph."""
        return _IMAGE_CAPTURED.encode(
            time_utc=EPOCH_US + p.time_us,
            time_boot_ms=p.time_us // 1000,
            lat=round(p.place.latitude_deg * 1e7),
            lon=round(p.place.longitude_deg * 1e7),
            alt=round(p.place.altitude_m * 1e3),
            relative_alt=round(p.height_m * 1e3),
            q=swap_quat_enu_flu_ned_frd(p.aim.quat_wxyz),
            image_index=p.index,
            capture_result=int(p.is_sound),
            file_url=p.name,
        )

    def _latest(self) -> bytes | None:
        latest = self._camera.photograph(self._camera.n_taken - 1)
        # Sent again on request; nothing to send before the first photograph.
        return None if latest is None else self.captured(latest)

    def _information(self) -> bytes:
        flags = _FLAGS | (_FILM_FLAGS if self._camera.can_film else 0)
        if self._payload.video is not None:
            flags |= mav.CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM
        return _CAMERA_INFORMATION.encode(
            time_boot_ms=self._view.time_boot_ms,
            vendor_name=b"AeroScene",
            model_name=b"Gimbal camera",
            firmware_version=_VERSION,
            focal_length=FOCAL_LENGTH_MM,
            sensor_size_h=SENSOR_MM[0],
            sensor_size_v=SENSOR_MM[1],
            resolution_h=SIZES_PX["photo"][0],
            resolution_v=SIZES_PX["photo"][1],
            flags=flags,
            gimbal_device_id=self._gimbal_device_id,
        )

    def _settings(self) -> bytes:
        is_video = self._camera.mode is CameraMode.VIDEO
        return _CAMERA_SETTINGS.encode(
            time_boot_ms=self._view.time_boot_ms,
            mode_id=mav.CAMERA_MODE_VIDEO if is_video else mav.CAMERA_MODE_IMAGE,
            # NaN: zoom and focus are fixed.
            zoomLevel=math.nan,
            focusLevel=math.nan,
        )

    def _storage(self) -> bytes:
        card = self._camera.card
        # Pictures that are only counted need no storage.
        if card.folder is None:
            return _STORAGE_INFORMATION.encode(
                time_boot_ms=self._view.time_boot_ms,
                storage_id=STORAGE_ID,
                storage_count=1,
                status=mav.STORAGE_STATUS_NOT_SUPPORTED,
            )
        return _STORAGE_INFORMATION.encode(
            time_boot_ms=self._view.time_boot_ms,
            storage_id=STORAGE_ID,
            storage_count=1,
            status=mav.STORAGE_STATUS_READY,
            total_capacity=CAPACITY_BYTES / _MIB,
            used_capacity=card.used_bytes / _MIB,
            available_capacity=card.free_bytes / _MIB,
            read_speed=math.nan,
            write_speed=math.nan,
            type=mav.STORAGE_TYPE_HD,
            name=b"captures",
            storage_usage=mav.STORAGE_USAGE_FLAG_PHOTO | mav.STORAGE_USAGE_FLAG_VIDEO,
        )

    def _capture_status(self) -> bytes:
        camera = self._camera
        filmed_us = camera.filmed_us
        return _CAPTURE_STATUS.encode(
            time_boot_ms=self._view.time_boot_ms,
            image_status=_IN_SERIES if camera.shutter.is_in_series else _IDLE,
            video_status=int(filmed_us is not None),
            image_interval=camera.shutter.interval_s,
            recording_time_ms=(filmed_us or 0) // 1000,
            available_capacity=camera.card.free_bytes / _MIB,
            image_count=camera.n_taken,
        )

    @staticmethod
    def _stream_fields(video: VideoStream) -> Mapping[str, object]:
        return {
            "stream_id": STREAM_ID,
            "flags": mav.VIDEO_STREAM_STATUS_FLAGS_RUNNING if video.is_running else 0,
            "framerate": float(RATE_HZ),
            "resolution_h": SIZES_PX["video"][0],
            "resolution_v": SIZES_PX["video"][1],
            "bitrate": BITRATE_BPS,
            "hfov": round(math.degrees(HORIZONTAL_FOV_RAD)),
        }

    def _stream_information(self, video: VideoStream) -> bytes:
        return _STREAM_INFORMATION.encode(
            **self._stream_fields(video),
            count=1,
            type=mav.VIDEO_STREAM_TYPE_RTPUDP,
            encoding=mav.VIDEO_STREAM_ENCODING_H264,
            name=b"Gimbal camera",
            uri=video.uri,
        )

    def _stream_status(self, video: VideoStream) -> bytes:
        return _STREAM_STATUS.encode(**self._stream_fields(video))
