"""RGB-D cameras: frames with depth and object ids, exact or with the errors of a real sensor.

Frames are rendered on request only, and from a copy of the state, so that a flight is the same to
the bit whether anybody looks or not.
"""

from flightsim.cameras.cameras import HEIGHT_PX, WIDTH_PX, Cameras
from flightsim.cameras.depth_noise import DepthNoise, depth_noise
from flightsim.cameras.renderer import CameraRenderer, open_camera_renderer
from flightsim.cameras.segmentation import CLASS_NAMES
from flightsim.cameras.view import CameraError, RgbdFrame, Viewpoint, look_at

__all__ = [
    "CLASS_NAMES",
    "HEIGHT_PX",
    "WIDTH_PX",
    "CameraError",
    "CameraRenderer",
    "Cameras",
    "DepthNoise",
    "RgbdFrame",
    "Viewpoint",
    "depth_noise",
    "look_at",
    "open_camera_renderer",
]
