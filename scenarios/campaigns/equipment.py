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
    """Equipment of a campaign's vehicles; the recipe decides the grade of GNSS and depth."""

    camera_size: str = "320x240"
    """Width and height of the images of the vehicle's cameras in pixels, 16 to 4096 each."""
    camera: tuple[str, ...] = ()
    """Cameras to change or to add, such as forward,fov=90,pitch=10 or left,yaw=90,x=0.1,y=0.05,z=0;
    degrees, and metres from the centre of mass. See docs/sensors.md."""
    light: str = ""
    """Time of day and weather of camera images: terms with commas between them, such as dusk, fog
    80 m or 11:30, rain, or random, which the seed of each trial draws; by default a fair afternoon.
    See docs/light.md."""
    season: Literal["spring", "summer", "autumn", "winter"] = "summer"
    """Season of leaves, grass and the date of the light: spring, summer, autumn or winter."""
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
        return replace(cfg, bench=replace(cfg.bench, **asdict(self)))

    def require(self, vehicle: str) -> None:
        """Refuse equipment that a vehicle cannot carry, before anything is flown.

        Raises:
            INPUT_ERRORS: If an option is invalid.
        """
        from flightsim.testbench import TestbenchCfg

        # Its checks run when it is made.
        TestbenchCfg(vehicle=vehicle, **asdict(self))

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
