"""Frames of a dataset for torch, each with its pose, its lens and the IMU before it.

Tables are held in memory, because they are small; images are read from their shard on demand, so
that a dataset may be larger than memory.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.spatial.transform import Rotation

from scenarios.recording.layout import AXES, BODY_AXES
from scenarios.trial_data.dataset.write import COMMITTED, SHARDS
from scenarios.trial_data.reading import TrialDataError, decoded
from scenarios.trial_data.tables import QUATERNION, names

if TYPE_CHECKING:
    import torch

_MM_PER_M = 1000.0  # depth images hold millimetres
_IMU = [*names("acceleration", BODY_AXES, "mps2"), *names("angular_rate", BODY_AXES, "radps")]
_LENS = ("focal_x_px", "focal_y_px", "centre_x_px", "centre_y_px")


class Frame(NamedTuple):
    """A frame as torch tensors, which a `DataLoader` stacks."""

    rgb: torch.Tensor
    """uint8 (3, height, width); zeros if no colours were recorded."""
    depth_m: torch.Tensor
    """float32 (1, height, width), along the optical axis; 0 if nothing was seen."""
    enu_from_optical: torch.Tensor
    """float32 (4, 4): true pose of the camera, x right, y down, z forward."""
    intrinsics_px: torch.Tensor
    """float32 (3, 3)."""
    classes: torch.Tensor
    """uint8 (1, height, width), see the table of labels; zeros without --segmentation."""
    instances: torch.Tensor
    """int32 (1, height, width), see the table of labels; zeros without --segmentation."""
    imu: torch.Tensor
    """float32 (n, 6): acceleration, m/s^2, and angular rate, rad/s, FLU, up to the frame's time."""
    time_us: torch.Tensor
    """int64: simulated time."""


class FrameDataset:
    """Frames of all trials of a dataset, map-style, as `torch.utils.data.DataLoader` takes them.

    Attributes:
        table: A row for each frame, with the columns of the table of frames.
    """

    def __init__(
        self, folder: Path | str, *, camera: str | None = None, imu_rows: int = 50
    ) -> None:
        """Read the tables; images are read on demand.

        Args:
            folder: Folder of the dataset.
            camera: Camera whose frames are wanted; None takes all.
            imu_rows: Number of IMU samples up to each frame; 50 are 0.2 s. Frames with fewer
                samples before them are left out.

        Raises:
            TrialDataError: If the folder holds no dataset, or none of its frames is wanted.
        """
        self._folder = Path(folder)
        self._imu_rows = imu_rows
        # A trial is complete if its table of trials is there; others are unfinished.
        trials = sorted((self._folder / COMMITTED).glob("*.parquet"))
        if not trials:
            raise TrialDataError(
                f"{str(folder)!r} holds no dataset; valid: a folder of `aeroscene export-trial`"
            )
        self._imu: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        tables = [self._frames(path.stem, camera) for path in trials]
        # Trials of earlier versions have no images of segments.
        self.table: pa.Table = pa.concat_tables(tables, promote_options="default")
        if not len(self.table):
            raise TrialDataError(f"{str(folder)!r} holds no frames of camera {camera or 'any'!r}")

    def __len__(self) -> int:
        return len(self.table)

    def __getitem__(self, index: int) -> Frame:
        import torch

        if not -len(self) <= index < len(self):
            raise IndexError(f"frame {index} is not among {len(self)}")
        # The remainder handles negative indices as a list does.
        row = self.table.slice(index % len(self), 1).to_pylist()[0]
        fx, fy, cx, cy = (row[name] for name in _LENS)
        pose = np.eye(4)
        quat_wxyz = [row[name] for name in names("attitude", QUATERNION)]
        pose[:3, :3] = Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()
        pose[:3, 3] = [row[name] for name in names("position", AXES, "m")]
        lens = np.array([(fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)])
        return Frame(
            rgb=torch.from_numpy(self._rgb(row)),
            depth_m=torch.from_numpy(self._depth_m(row)),
            enu_from_optical=torch.from_numpy(pose.astype(np.float32)),
            intrinsics_px=torch.from_numpy(lens.astype(np.float32)),
            classes=torch.from_numpy(self._segments(row, "classes", np.uint8)),
            instances=torch.from_numpy(self._segments(row, "instances", np.int32)),
            imu=torch.from_numpy(self._imu_before(row["trial"], row["time_us"])),
            time_us=torch.tensor(row["time_us"]),
        )

    def _frames(self, trial: str, camera: str | None) -> pa.Table:
        """Return the wanted frames of a trial, and keep its IMU."""
        frames = pq.read_table(self._folder / "frames" / f"{trial}.parquet")
        imu = pq.read_table(self._folder / "imu" / f"{trial}.parquet", columns=["time_us", *_IMU])
        values = np.column_stack([imu[name].to_numpy() for name in _IMU]).astype(np.float32)
        time_us = imu["time_us"].to_numpy()
        self._imu[trial] = time_us, values
        # Enough IMU samples before the frame.
        is_wanted = np.searchsorted(time_us, frames["time_us"], side="right") >= self._imu_rows
        if camera is not None:
            is_wanted &= np.array(frames["camera"].to_pylist(), dtype=object) == camera
        return frames.filter(pa.array(is_wanted))

    def _imu_before(self, trial: str, time_us: int) -> np.ndarray:
        times_us, values = self._imu[trial]
        end = np.searchsorted(times_us, time_us, side="right")
        return values[end - self._imu_rows : end]

    def _rgb(self, row: dict[str, Any]) -> np.ndarray:
        rgb = self._image(row, "rgb")
        if rgb is None:
            return np.zeros((3, row["height_px"], row["width_px"]), dtype=np.uint8)
        return np.ascontiguousarray(rgb.transpose(2, 0, 1))

    def _depth_m(self, row: dict[str, Any]) -> np.ndarray:
        millimetres = self._image(row, "depth")
        if millimetres is None:
            return np.zeros((1, row["height_px"], row["width_px"]), dtype=np.float32)
        return (millimetres / _MM_PER_M).astype(np.float32)[None]

    def _segments(self, row: dict[str, Any], kind: str, dtype: type) -> np.ndarray:
        image = self._image(row, kind)
        if image is None:
            return np.zeros((1, row["height_px"], row["width_px"]), dtype=dtype)
        return image.astype(dtype)[None]

    def _image(self, row: dict[str, Any], kind: str) -> np.ndarray | None:
        """Return an image of a frame, read from the shard; None if there is none.

        Raises:
            TrialDataError: If the shard is damaged.
        """
        if row.get(f"{kind}_offset") is None:
            return None
        shard = self._folder / SHARDS / f"{row['trial']}.tar"
        # Opened for each image: file objects cannot be shared by the processes of a `DataLoader`.
        with shard.open("rb") as file:
            file.seek(row[f"{kind}_offset"])
            return decoded(file.read(row[f"{kind}_bytes"]), f"shard {str(shard)!r}")
