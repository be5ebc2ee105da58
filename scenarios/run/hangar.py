"""Resources that one process keeps between flights: opened scenes and renderers.

Other slow things are kept where they are made: distance fields, parts of objects, solved winds,
compiled kernels and the planner's programs. A world is built anew for each flight, because it holds
the start; that takes 15 ms.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace
from typing import Self

from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from flightsim.cameras import (
    CameraRenderer,
    Cameras,
    depth_noise,
    open_camera_renderer,
)
from flightsim.cameras.optics import Optics
from flightsim.looks.light import Light
from flightsim.testbench import Vehicle
from flightsim.vehicles import Airframe
from flightsim.world import World

_View = tuple[Scene, Airframe, tuple[int, int], Light]
"""Key of a renderer: scene, vehicle, size of the images, light."""
_KEPT = 2
"""Number of scenes, and of renderers, that are kept: a campaign flies scene by scene."""


class Hangar:
    """Keeps resources that flights in the same scene share.

    A flight is the same, bit for bit, from a hangar that has served others and from an empty one.
    """

    def __init__(self) -> None:
        self._scenes: OrderedDict[str, Scene] = OrderedDict()
        self._renderers: OrderedDict[_View, CameraRenderer] = OrderedDict()

    def scene(self, name: str) -> Scene:
        """Return the scene of a name, see `load_scene`; a file is not read again.

        Raises:
            SceneError: If there is no such scene.
        """
        scene = self._scenes.pop(name, None) or load_scene(name)
        self._scenes[name] = scene
        if len(self._scenes) > _KEPT:
            self._scenes.popitem(last=False)
        return scene

    def cameras(self, vehicle: Vehicle) -> Cameras:
        """Return the cameras of a vehicle in a testbench.

        Worlds that differ only by the start share one renderer, which stays open and belongs to the
        hangar. If anything else moves, the cameras have a renderer of their own.
        """
        plant, cfg = vehicle.plant, vehicle.cfg
        number, scene_id = plant.world.number, vehicle.scene.scene_id
        name = f"{scene_id}, vehicle {number + 1}" if number else scene_id
        noise = depth_noise(cfg.depth_camera, cfg.seed, name)
        # Only then does a picture depend on nothing but scene, airframe and pose.
        is_alone = plant.world.n_vehicles == 1 and not plant.world.obstacles
        size_px = width_px, height_px = cfg.camera_size_px
        optics = cfg.optics
        renderer = self._renderer(plant.world, size_px) if is_alone else None
        return Cameras(
            plant,
            width_px=width_px,
            height_px=height_px,
            depth_noise=noise,
            segments=cfg.segmentation,
            optics=None if optics.is_plain else Optics(optics, cfg.seed, name),
            renderer=renderer,
        )

    def _renderer(self, world: World, size_px: tuple[int, int]) -> CameraRenderer:
        scene = world.scene
        # The start is no part of the picture: one key for all starts of a scene.
        corner = replace(scene, start_position_enu_m=scene.extent_min_enu_m, start_yaw_rad=0.0)
        key = (corner, world.airframe, size_px, world.light)
        renderer = self._renderers.pop(key, None)
        if renderer is None:
            renderer = open_camera_renderer(world, *size_px)
        self._renderers[key] = renderer
        if len(self._renderers) > _KEPT:
            self._renderers.popitem(last=False)[1].close()
        return renderer

    def close(self) -> None:
        """Close every renderer."""
        while self._renderers:
            self._renderers.popitem()[1].close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
