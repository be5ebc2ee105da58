"""Segments of the cameras and scans of a lidar come back from a recording."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene import load_scene
from flightsim.cameras import CLASS_NAMES, Cameras
from flightsim.lidars import LIDARS, Lidar
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.recording import Recorder, RunInfo, layout
from tests.scenarios.recording.conftest import Contents


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    path = tmp_path_factory.mktemp("sensors") / "flight.rrd"
    world = build_world(load_scene("42"), AIRFRAMES["iris"])
    plant = Plant(world, PlantCfg(seed=0))
    lidar = Lidar(plant, replace(LIDARS["mid40"], scan_hz=20.0))
    info = RunInfo(scene=world.scene.scene_id, vehicle="iris", seed=0)
    scans = []
    with (
        Cameras(plant, width_px=32, height_px=24, segments=True) as cameras,
        Recorder(
            path,
            scene=world.scene,
            primitives=world.solids,
            airframe=world.airframe,
            info=info,
            has_segments=True,
        ) as recorder,
    ):
        cameras.listen(recorder.first.log_frame)
        lidar.listeners += [recorder.first.log_scan, scans.append]
        for _ in range(8):
            plant.advance()
            lidar.update()
            recorder.on_tick(plant)
        frame = cameras.render("forward")
    return Contents(path), frame, scans


def test_segments_come_back_with_what_they_mean(flown):
    contents, frame, _ = flown
    for entity, image in (
        (layout.camera_classes("forward"), frame.class_ids),
        (layout.camera_instances("forward"), frame.instance_ids.astype(np.uint16)),
    ):
        times_us, (pixels,) = contents.column(entity, "SegmentationImage:buffer")
        assert times_us.tolist() == [frame.time_us]
        raw = np.frombuffer(bytes(pixels[0]), image.dtype)
        np.testing.assert_array_equal(raw.reshape(image.shape), image)
        _, ((context,),) = contents.column(entity, "AnnotationContext:context")
        names = {
            entry["class_id"]: entry["class_description"]["info"]["label"] for entry in context
        }
        assert set(np.unique(image).tolist()) <= set(names)
        if image is frame.class_ids:
            assert names == dict(CLASS_NAMES)
        else:
            assert names[-101 % (1 << 16)] == "vehicle 2"


def test_scans_come_back_point_by_point(flown):
    contents, _, scans = flown
    times_us, positions = contents.column(layout.LIDAR, "Points3D:positions")
    assert times_us.tolist() == [scan.time_us for scan in scans]
    assert len(scans) == 3
    for scan, points in zip(scans, positions, strict=True):
        np.testing.assert_allclose(np.array(points), scan.points_flu_m, atol=1e-4)
        assert len(points) > 1000
    _, colours = contents.column(layout.LIDAR, "Points3D:colors")
    assert len(colours[0]) == len(positions[0])
