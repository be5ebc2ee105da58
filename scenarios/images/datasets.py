"""Labelled images for torch: dense labels from the shards, and detection from the COCO file.

torch is imported with the first item, so that a set can be opened without it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.images.coco import COCO
from scenarios.images.encoding import decoded, depth_of, flow_of, ids_of, normals_of
from scenarios.images.labels.rle import decode_mask
from scenarios.images.reading import FrameReader
from scenarios.images.request import ImagesError

if TYPE_CHECKING:
    import torch


class LabelledImage(NamedTuple):
    """A frame as torch tensors of fixed shapes, which a `DataLoader` stacks."""

    rgb: torch.Tensor
    """uint8 (3, height, width)."""
    next_rgb: torch.Tensor
    """uint8 (3, height, width): the second image, a short time later."""
    depth_m: torch.Tensor
    """float32 (1, height, width), along the optical axis; inf in the sky, at most 65.535."""
    normals: torch.Tensor
    """float32 (3, height, width), in the optical frame; 0 in the sky."""
    flow_px: torch.Tensor
    """float32 (2, height, width), right and down, to the second image."""
    flow_kind: torch.Tensor
    """uint8 (1, height, width): 0 no flow, 1 not seen in the second image, 2 seen there."""
    classes: torch.Tensor
    """uint8 (1, height, width): categories, see `flightsim.cameras.CLASS_NAMES`."""
    instances: torch.Tensor
    """int32 (1, height, width): ids of objects; -2 ground, -3 sky, -4 surroundings, -10... movers.
    """
    enu_from_optical: torch.Tensor
    """float32 (4, 4): pose of the camera, x right, y down, z forward."""
    next_enu_from_optical: torch.Tensor
    """float32 (4, 4): its pose in the second image."""
    intrinsics_px: torch.Tensor
    """float32 (3, 3)."""


class LabelledImages:
    """Frames of a set with their dense labels, map-style, as `torch.utils.data.DataLoader` takes.

    Boxes, masks and areas have no fixed number; `facts` returns them.
    """

    def __init__(self, folder: Path | str) -> None:
        """Open a set.

        Args:
            folder: Folder that `aeroscene images` has made.

        Raises:
            ImagesError: If the folder holds no frames.
        """
        self._reader = FrameReader(folder)

    def __len__(self) -> int:
        return self._reader.n_frames

    def __getitem__(self, index: int) -> LabelledImage:
        import torch

        read, facts = self._reader.image, self._reader.facts(index)
        flow_px, flow_kind = flow_of(read(index, "flow.png"))

        def tensor(image: np.ndarray) -> torch.Tensor:
            channels = image.transpose(2, 0, 1) if image.ndim == 3 else image[None]
            return torch.from_numpy(np.ascontiguousarray(channels))

        lens = facts["camera"]
        intrinsics = np.array(
            [
                (lens["focal_x_px"], 0.0, lens["centre_x_px"]),
                (0.0, lens["focal_y_px"], lens["centre_y_px"]),
                (0.0, 0.0, 1.0),
            ]
        )
        return LabelledImage(
            rgb=tensor(read(index, "rgb.jpg")),
            next_rgb=tensor(read(index, "next.jpg")),
            depth_m=tensor(depth_of(read(index, "depth.png"))),
            normals=tensor(normals_of(read(index, "normals.png"))),
            flow_px=tensor(flow_px),
            flow_kind=tensor(flow_kind),
            classes=tensor(read(index, "classes.png")),
            instances=tensor(ids_of(read(index, "instances.png"))),
            enu_from_optical=torch.from_numpy(_matrix(facts["pose"])),
            next_enu_from_optical=torch.from_numpy(_matrix(facts["next"])),
            intrinsics_px=torch.from_numpy(intrinsics.astype(np.float32)),
        )

    def facts(self, index: int) -> dict[str, Any]:
        """Return the facts of a frame: scene, light, camera, poses, instances, areas."""
        return self._reader.facts(index)


class Detection(NamedTuple):
    """Instances of a frame as torchvision's detectors take them."""

    boxes: torch.Tensor
    """float32 (n, 4): left, top, right, bottom in pixels; right and bottom are excluded."""
    labels: torch.Tensor
    """int64 (n,): categories of the COCO file."""
    masks: torch.Tensor
    """uint8 (n, height, width): 1 on the instance."""
    image_id: torch.Tensor
    """int64: number of the frame."""


class DetectionImages:
    """Images of a COCO file with boxes and masks, map-style.

    The number of instances differs from image to image: pass `collate_fn=DetectionImages.collate`
    to a `DataLoader`.
    """

    def __init__(
        self, folder: Path | str, categories: tuple[str, ...] | None = None, least_pixels: int = 0
    ) -> None:
        """Read the annotations.

        Args:
            folder: Folder that `aeroscene images` has made.
            categories: Names of the categories that are wanted; None takes all.
            least_pixels: Fewest pixels of an instance that is wanted.

        Raises:
            ImagesError: If there are no annotations, or a category is unknown.
        """
        path = Path(folder) / COCO
        try:
            content = json.loads(path.read_bytes())
        except FileNotFoundError:
            raise ImagesError(
                f"{str(path)!r} is missing; valid: a folder in which `aeroscene images` has ended"
            ) from None
        self._images_folder = path.parent / "images"
        names = {row["name"]: row["id"] for row in content["categories"]}
        for name in categories or ():
            if name not in names:
                valid = ", ".join(names)
                raise ImagesError(f"category {name!r} is unknown; valid: {valid}")
        self.categories = {
            number: name
            for name, number in names.items()
            if categories is None or name in categories
        }
        """Names of the wanted categories by their numbers."""
        self._images = content["images"]
        self._annotations: dict[int, list[dict[str, Any]]] = {row["id"]: [] for row in self._images}
        for row in content["annotations"]:
            if row["category_id"] in self.categories and row["area"] >= least_pixels:
                self._annotations[row["image_id"]].append(row)

    def __len__(self) -> int:
        return len(self._images)

    def __getitem__(self, index: int) -> tuple[torch.Tensor, Detection]:
        import torch

        image = self._images[index]
        path = self._images_folder / image["file_name"]
        rgb = decoded(path.read_bytes(), f"file {str(path)!r}").transpose(2, 0, 1)
        rows = self._annotations[image["id"]]
        corners = np.array([row["bbox"] for row in rows], np.float32).reshape(-1, 4)
        corners[:, 2:] += corners[:, :2]
        masks = np.zeros((len(rows), image["height"], image["width"]), np.uint8)
        for mask, row in zip(masks, rows, strict=True):
            mask[:] = decode_mask(row["segmentation"])
        labels = np.array([row["category_id"] for row in rows], np.int64)
        return torch.from_numpy(np.ascontiguousarray(rgb)), Detection(
            boxes=torch.from_numpy(corners),
            labels=torch.from_numpy(labels),
            masks=torch.from_numpy(masks),
            image_id=torch.tensor(image["id"]),
        )

    @staticmethod
    def collate(
        batch: list[tuple[torch.Tensor, Detection]],
    ) -> tuple[list[torch.Tensor], list[Detection]]:
        """Return images and detections of a batch in two lists."""
        return [rgb for rgb, _ in batch], [detection for _, detection in batch]


def _matrix(pose: dict[str, Any]) -> np.ndarray:
    matrix = np.eye(4, dtype=np.float32)
    turn = Rotation.from_quat(pose["quat_wxyz"], scalar_first=True)
    matrix[:3, :3] = turn.as_matrix()
    matrix[:3, 3] = pose["position_enu_m"]
    return matrix
