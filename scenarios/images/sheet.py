"""Contact sheet of a set: some frames, each with its labels drawn side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import UInt8
from PIL import Image

from aeroscene.files import replacing
from scenarios.images.encoding import depth_of, flow_of
from scenarios.images.reading import FrameReader

MOST_ROWS = 8
_PANEL_PX = 400
_GAP_PX = 6
_FARTHEST_M, _NEAREST_M = 60.0, 0.5
_MOST_FLOW_PX = 20.0
_BOX_RGB, _BOX3D_RGB, _CUT_RGB = (255, 220, 40), (60, 230, 255), (255, 130, 40)
_AREA_RGB = {"landing": (60, 255, 90), "perching": (255, 90, 220)}
_LEAST_PIXELS = 150
_WIDEST_SHARE = 0.3
"""Instances that fill more of an image, such as lawns, get no box on the sheet: it hides others."""
_EDGES = [(a, a | 1 << k) for a in range(8) for k in range(3) if not a & 1 << k]

Picture = UInt8[np.ndarray, "height width 3"]


def write_sheet(folder: Path, out: Path, rows: int = MOST_ROWS) -> int:
    """Draw frames that are spread over a set into a PNG file.

    From left to right: boxes and areas, boxes in the world, depth, normals, instances, flow.

    Args:
        folder: Folder of the set.
        out: File to write.
        rows: Most frames.

    Returns:
        Number of frames that are drawn.

    Raises:
        ImagesError: If the folder holds no frames.
        OSError: If the file cannot be written.
    """
    reader = FrameReader(folder)
    n_rows = min(rows, reader.n_frames)
    picked = np.linspace(0, reader.n_frames - 1, n_rows).astype(int).tolist()
    strips = [_strip(reader, index) for index in picked]
    width = max(strip.shape[1] for strip in strips)
    # Frames of another size are shorter or longer; white fills the rest.
    padded = [
        np.pad(strip, ((0, 0), (0, width - strip.shape[1]), (0, 0)), constant_values=255)
        for strip in strips
    ]
    with replacing(out) as file:
        Image.fromarray(np.vstack(padded)).save(file, format="png")
    return n_rows


def _strip(reader: FrameReader, index: int) -> Picture:
    facts = reader.facts(index)
    rgb = reader.image(index, "rgb.jpg")
    panels = [
        _with_boxes(rgb.copy(), facts),
        _with_boxes_3d(rgb.copy(), facts),
        _depth_rgb(depth_of(reader.image(index, "depth.png"))),
        reader.image(index, "normals.png"),
        _mixed(rgb, _instance_rgb(reader.image(index, "instances.png"))),
        _flow_rgb(*flow_of(reader.image(index, "flow.png"))),
    ]
    height = round(_PANEL_PX * rgb.shape[0] / rgb.shape[1])
    gap = np.full((height, _GAP_PX, 3), 255, np.uint8)
    cells = []
    for panel in panels:
        cells += [cv2.resize(panel, (_PANEL_PX, height), interpolation=cv2.INTER_AREA), gap]
    strip = np.hstack(cells)
    said = f"{facts['frame']}  {facts['scene']}  {facts['light']}  {facts['season']}"
    cv2.putText(strip, said, (6, height - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 3)
    cv2.putText(strip, said, (6, height - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1)
    return np.vstack([strip, np.full((_GAP_PX, strip.shape[1], 3), 255, np.uint8)])


def _with_boxes(rgb: Picture, facts: dict[str, Any]) -> Picture:
    for each in _shown(facts, rgb):
        left, top, width, height = each["box_px"]
        colour = _CUT_RGB if each["is_cut"] else _BOX_RGB
        cv2.rectangle(rgb, (left, top), (left + width - 1, top + height - 1), colour, 1)
        cv2.putText(
            rgb, each["category"], (left, top - 3), cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1
        )
    for area in facts["areas"]:
        rings = [np.rint(ring).astype(np.int32) for ring in area["polygons_px"]]
        cv2.polylines(rgb, rings, True, _AREA_RGB[area["kind"]], 2)
    return rgb


def _with_boxes_3d(rgb: Picture, facts: dict[str, Any]) -> Picture:
    for each in _shown(facts, rgb):
        if each["box3d"]["corners_px"] is not None:
            corners = np.clip(np.array(each["box3d"]["corners_px"]), -1e4, 1e4).astype(np.int32)
            for a, b in _EDGES:
                cv2.line(rgb, corners[a].tolist(), corners[b].tolist(), _BOX3D_RGB, 1, cv2.LINE_AA)
    return rgb


def _shown(facts: dict[str, Any], rgb: Picture) -> list[dict[str, Any]]:
    most = _WIDEST_SHARE * rgb.shape[0] * rgb.shape[1]
    return [
        each
        for each in facts["instances"]
        if each["pixels"] >= _LEAST_PIXELS and each["box_px"][2] * each["box_px"][3] <= most
    ]


def _depth_rgb(depth_m: np.ndarray) -> Picture:
    near = np.log(_FARTHEST_M / np.clip(depth_m, _NEAREST_M, _FARTHEST_M))
    grey = np.rint(255.0 * near / np.log(_FARTHEST_M / _NEAREST_M)).astype(np.uint8)
    colours = cv2.applyColorMap(grey, cv2.COLORMAP_TURBO)[:, :, ::-1]
    return np.where(np.isinf(depth_m)[..., None], np.uint8(0), colours)


def _instance_rgb(ids: np.ndarray) -> Picture:
    # Multiples of large odd numbers: neighbouring ids get colours far apart.
    number = ids.astype(np.uint32) + 1
    return np.stack([(number * k >> 7) & 255 for k in (40503, 30323, 50021)], -1).astype(np.uint8)


def _mixed(rgb: Picture, over: Picture) -> Picture:
    return cv2.addWeighted(rgb, 0.35, over, 0.65, 0.0)


def _flow_rgb(flow_px: np.ndarray, kind: np.ndarray) -> Picture:
    """Direction as hue and length as saturation; hidden points are darker, none are black."""
    length = np.linalg.norm(flow_px, axis=2)
    angle = np.arctan2(flow_px[..., 1], flow_px[..., 0])
    hue = np.rint((angle + np.pi) / (2 * np.pi) * 179).astype(np.uint8)
    full = np.rint(255 * np.minimum(length / _MOST_FLOW_PX, 1.0)).astype(np.uint8)
    value = np.array([0, 120, 255], np.uint8)[kind]
    return cv2.cvtColor(np.stack([hue, full, value], -1), cv2.COLOR_HSV2RGB)
