"""Cameras and sensors that the vehicle of every trial carries, by the options of `sitl`."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from aeroscene.ranges import Range

if TYPE_CHECKING:
    # The whole simulator, which `--help` does not need.
    from scenarios.run.cfg import SitlCfg

MOST_CAMERA_HZ = 50.0


@dataclass(frozen=True, kw_only=True)
class Equipment:
    """Equipment of a campaign's vehicles; the recipe decides the grade of GNSS and depth.

    Light and season are the recipe's too, unless they are named here.
    """

    camera_size: str = "320x240"
    """Width and height of the images of the vehicle's cameras in pixels, 16 to 4096 each."""
    camera: tuple[str, ...] = ()
    """Cameras to change or to add, such as forward,fov=90,pitch=10 or left,yaw=90,x=0.1,y=0.05,z=0;
    degrees, and metres from the centre of mass. See docs/sensors.md."""
    light: str = ""
    """Time of day and weather of camera images: terms with commas between them, such as dusk, fog
    80 m or 11:30, rain, or random, which the seed of each trial draws; by default as the recipe has
    it. See docs/light.md."""
    season: Literal["recipe", "spring", "summer", "autumn", "winter"] = "recipe"
    """Season of leaves, grass and the date of the light: spring, summer, autumn or winter, or as
    the recipe has it."""
    camera_exposure: Annotated[float, Range(-6.0, 6.0, "EV")] = 0.0
    """Exposure of the cameras' colours: each unit doubles the light."""
    camera_gamma: Annotated[float, Range(0.2, 5.0)] = 1.0
    """Gamma of the cameras' colours: above 1 is brighter, below is darker."""
    camera_motion_blur: Annotated[float, Range(0.0, 50.0, "ms")] = 0.0
    """Time for which each pixel of the colours gathers light."""
    camera_rolling_shutter: Annotated[float, Range(0.0, 50.0, "ms")] = 0.0
    """Time from the first row of the colours to the last."""
    camera_distortion: str = "none"
    """Distortion of the colours by the lens: K1[,K2[,P1[,P2]]] of Brown and Conrady, such as
    -0.2,0.05. Depth and labels stay a pinhole's. See docs/sensors.md."""
    camera_noise: Annotated[float, Range(0.0, 64.0, "levels of 255")] = 0.0
    """Noise of the cameras' colours: standard deviation of mid-grey."""
    segmentation: bool = False
    """Record the object and the class of each pixel of the camera images."""
    lidar: str = ""
    """Lidar to carry: vlp16, mid40, or a file FILE.toml or FILE.csv; see docs/sensors.md."""
    optical_flow: bool = False
    """Carry a sensor of optical flow that looks down, and report it by MAVLink."""

    def fitted(self, cfg: SitlCfg) -> SitlCfg:
        """Return the configuration of a run whose vehicle carries this equipment.

        Raises:
            INPUT_ERRORS: If an option is invalid.
        """
        return replace(cfg, bench=replace(cfg.bench, **self._options()))

    def require(self, vehicle: str) -> None:
        """Refuse equipment that a vehicle cannot carry, before anything is flown.

        Raises:
            INPUT_ERRORS: If an option is invalid.
        """
        from flightsim.testbench import TestbenchCfg

        # Its checks run when it is made.
        TestbenchCfg(vehicle=vehicle, **self._options())

    def _options(self) -> dict[str, Any]:
        """Options of the testbench, without those that the recipe decides."""
        left = {name for name, value in (("light", ""), ("season", "recipe"))
                if getattr(self, name) == value}  # fmt: skip
        return {name: value for name, value in asdict(self).items() if name not in left}

    def to_plain(self) -> dict[str, Any]:
        """Return the options as plain data."""
        return asdict(self)


CameraHz = Annotated[float, Range(0.0, MOST_CAMERA_HZ, "Hz")]
"""Frames of each camera in a simulated second of a recording."""


def equipment_from(plain: dict[str, Any]) -> Equipment:
    """Return the equipment in the plain data of a suite; earlier versions of the format had none.

    Raises:
        TypeError: If it holds a name that is no option.
    """
    options = dict(plain.get("equipment", {}))
    # JSON has lists; the option compares as a tuple.
    options["camera"] = tuple(options.get("camera", ()))
    return Equipment(**options)
