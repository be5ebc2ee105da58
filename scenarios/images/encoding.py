"""Images of a frame as files, and back."""

from __future__ import annotations

import cv2
import numpy as np
from jaxtyping import Float, Int, UInt8, UInt16

from scenarios.images.frame import LabelledFrame
from scenarios.images.request import MOST_OBJECT_ID, ImagesError

FARTHEST_MM = 65_535
"""Value of depths of 65.535 m or more; 0 is the sky."""
_JPEG_QUALITY = 95
_FLOW_ZERO, _FLOW_SCALE = 32_768.0, 64.0
"""KITTI's flow: 64 steps a pixel about the middle of 16 bits."""
SUFFIXES = (
    *("rgb.jpg", "next.jpg", "depth.png", "normals.png"),
    *("flow.png", "classes.png", "instances.png", "json"),
)
"""Endings of a frame's files, in their order in a shard."""


def encoded(frame: LabelledFrame) -> dict[str, bytes]:
    """Return the images of a frame as JPEG and PNG, by their endings."""
    return {
        "rgb.jpg": _jpeg(frame.rgb),
        "next.jpg": _jpeg(frame.next_rgb),
        "depth.png": _png(_depth_mm(frame.depth_m)),
        "normals.png": _png(_normal_pixels(frame.normals)),
        "flow.png": _png(_flow_pixels(frame.flow_px, frame.flow_kind)),
        "classes.png": _png(frame.class_ids),
        # Ids below zero wrap around, as in recordings: the sky, -3, is 65533.
        "instances.png": _png(frame.instance_ids.astype(np.uint16)),
    }


def decoded(data: bytes, where: str) -> np.ndarray:
    """Return the pixels of an image, (h, w) or (h, w, 3) with red first.

    Args:
        data: JPEG or PNG.
        where: Words for its place, for the message.

    Raises:
        ImagesError: If it is damaged.
    """
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None:
        raise ImagesError(f"an image of {where} is damaged; valid: one that was written whole")
    return np.ascontiguousarray(image[:, :, ::-1]) if image.ndim == 3 else image


def depth_of(pixels: UInt16[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """Return depth in m, float32; inf in the sky."""
    depth_m = pixels.astype(np.float32) / np.float32(1000.0)
    depth_m[pixels == 0] = np.inf
    return depth_m


def normals_of(pixels: UInt8[np.ndarray, "h w 3"]) -> Float[np.ndarray, "h w 3"]:
    """Return unit normals in the optical frame, float32; 0 in the sky."""
    normals = pixels.astype(np.float32) / np.float32(127.5) - np.float32(1.0)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    return np.where(pixels.any(axis=2, keepdims=True), normals / length, np.float32(0.0))


def flow_of(
    pixels: UInt16[np.ndarray, "h w 3"],
) -> tuple[Float[np.ndarray, "h w 2"], UInt8[np.ndarray, "h w"]]:
    """Return flow in pixels, float32, and the kind of each pixel."""
    flow = (pixels[:, :, :2].astype(np.float32) - np.float32(_FLOW_ZERO)) / np.float32(_FLOW_SCALE)
    kind = pixels[:, :, 2].astype(np.uint8)
    return np.where(kind[..., None] > 0, flow, np.float32(0.0)), kind


def ids_of(pixels: UInt16[np.ndarray, "h w"]) -> Int[np.ndarray, "h w"]:
    """Return object ids, int32, with those below zero as they were."""
    ids = pixels.astype(np.int32)
    return np.where(ids > MOST_OBJECT_ID, ids - (1 << 16), ids)


def _depth_mm(depth_m: Float[np.ndarray, "h w"]) -> UInt16[np.ndarray, "h w"]:
    is_seen = np.isfinite(depth_m)
    millimetres = np.rint(np.where(is_seen, depth_m, 0.0) * 1000.0)
    # At least 1, because 0 is the sky.
    return np.where(is_seen, np.clip(millimetres, 1, FARTHEST_MM), 0).astype(np.uint16)


def _normal_pixels(normals: Float[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "h w 3"]:
    pixels = np.rint(127.5 * (normals + 1.0)).astype(np.uint8)
    pixels[~normals.any(axis=2)] = 0
    return pixels


def _flow_pixels(
    flow_px: Float[np.ndarray, "h w 2"], kind: UInt8[np.ndarray, "h w"]
) -> UInt16[np.ndarray, "h w 3"]:
    steps = np.rint(_FLOW_SCALE * flow_px + _FLOW_ZERO)
    pixels = np.concatenate([steps, kind[..., None]], axis=2).astype(np.uint16)
    pixels[kind == 0] = 0
    return pixels


def _jpeg(rgb: UInt8[np.ndarray, "h w 3"]) -> bytes:
    settings = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    return cv2.imencode(".jpg", rgb[:, :, ::-1], settings)[1].tobytes()


def _png(image: np.ndarray) -> bytes:
    # OpenCV has blue first. The difference from the pixel above suits all of these images.
    pixels = image[:, :, ::-1] if image.ndim == 3 else image
    settings = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP]
    return cv2.imencode(".png", np.ascontiguousarray(pixels), settings)[1].tobytes()
