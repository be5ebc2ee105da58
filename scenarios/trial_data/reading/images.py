"""Encoded images of a recording as arrays."""

from __future__ import annotations

import numpy as np

from scenarios.trial_data.reading.error import TrialDataError


def decoded(data: bytes, where: str) -> np.ndarray:
    """Decode a JPEG to uint8 (height, width, 3), red first, or depth to uint16 (height, width), mm.

    Args:
        data: The encoded image.
        where: Words for its container, for the message.

    Raises:
        TrialDataError: If it is damaged.
    """
    import cv2

    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None:
        raise TrialDataError(f"an image of {where} is damaged; valid: one that was written whole")
    # OpenCV has blue first.
    return np.ascontiguousarray(image[:, :, ::-1]) if image.ndim == 3 else image
