"""Sets as torch reads them, beside the files and the scene."""

import json
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from scenarios.images.build import read_manifest
from scenarios.images.datasets import DetectionImages, LabelledImages
from scenarios.images.encoding import _flow_pixels, _normal_pixels, flow_of, normals_of
from scenarios.images.labels.rle import decode_mask
from scenarios.images.request import ImagesError
from tests.scenarios.images.conftest import N_FRAMES


def test_dense_labels_are_those_of_the_frames(folder, frames):
    torch = pytest.importorskip("torch")
    images = LabelledImages(folder)
    assert len(images) == N_FRAMES
    for item, frame in zip((images[k] for k in range(N_FRAMES)), frames, strict=True):
        np.testing.assert_array_equal(item.depth_m[0].numpy(), frame.depth_m)
        np.testing.assert_array_equal(item.instances[0].numpy(), frame.ids)
        np.testing.assert_array_equal(item.flow_px.numpy().transpose(1, 2, 0), frame.flow_px)
        np.testing.assert_array_equal(item.normals.numpy().transpose(1, 2, 0), frame.normals)
        camera = frame.camera
        pose = item.enu_from_optical.numpy()
        np.testing.assert_allclose(pose[:3, 3], camera.pose.position_enu_m, atol=1e-5)
        np.testing.assert_allclose(pose[:3, :3], camera.pose.rotation_enu_from_optical, atol=1e-6)
        assert item.intrinsics_px[0, 0].item() == pytest.approx(camera.focal_px)
        assert item.rgb.dtype == item.next_rgb.dtype == torch.uint8
        # The second image is of another moment.
        assert (item.rgb != item.next_rgb).float().mean() > 0.2


def test_a_loader_stacks_frames_in_other_processes(folder):
    data = pytest.importorskip("torch.utils.data")
    loader = data.DataLoader(LabelledImages(folder), batch_size=4, num_workers=1)
    batches = list(loader)
    assert [tuple(batch.rgb.shape) for batch in batches] == [(4, 3, 120, 160)] * 2
    assert tuple(batches[0].flow_px.shape) == (4, 2, 120, 160)
    assert tuple(batches[0].enu_from_optical.shape) == (4, 4, 4)


def test_detections_are_the_annotations_of_the_coco_file(folder, frames):
    pytest.importorskip("torch")
    images = DetectionImages(folder)
    for index, frame in enumerate(frames):
        rgb, found = images[index]
        assert tuple(rgb.shape) == (3, 120, 160)
        labels = [*frame.facts["instances"], *frame.facts["areas"]]
        assert len(found.boxes) == len(labels)
        for box, mask, each in zip(found.boxes, found.masks, labels, strict=True):
            left, top, width, height = each["box_px"]
            assert box.tolist() == [left, top, left + width, top + height]
            np.testing.assert_array_equal(mask.numpy() == 1, decode_mask(each["rle"]))


def test_detections_can_be_of_some_categories_alone(folder):
    pytest.importorskip("torch")
    everything, trees = DetectionImages(folder), DetectionImages(folder, ("tree",))
    assert list(trees.categories.values()) == ["tree"]
    n_all = sum(len(everything[k][1].boxes) for k in range(N_FRAMES))
    n_trees = sum(len(trees[k][1].boxes) for k in range(N_FRAMES))
    assert 0 < n_trees < n_all
    with pytest.raises(ImagesError, match="category 'treee' is unknown; valid: "):
        DetectionImages(folder, ("treee",))


def test_the_coco_file_has_what_its_readers_ask_for(folder):
    content = json.loads((folder / "coco/annotations.json").read_bytes())
    assert content["licenses"] == []
    numbers = {row["id"] for row in content["categories"]}
    frames = {row["id"]: row for row in content["images"]}
    assert len(frames) == N_FRAMES
    assert [row["id"] for row in content["annotations"]] == list(
        range(1, len(content["annotations"]) + 1)
    )
    for row in content["annotations"]:
        assert row["category_id"] in numbers
        image = frames[row["image_id"]]
        assert row["segmentation"]["size"] == [image["height"], image["width"]]
        assert row["iscrowd"] == 0
    for row in content["images"]:
        with Image.open(folder / "coco/images" / row["file_name"]) as picture:
            assert picture.size == (row["width"], row["height"])
    names = {row["name"] for row in content["categories"]}
    assert {"tree", "car", "person", "landing area, small", "perching area, small"} <= names


def test_the_sheet_shows_every_frame(folder):
    with Image.open(folder.parent / "sheet.png") as sheet:
        width, height = sheet.size
    assert width > 2000
    assert height == N_FRAMES * 306


def test_what_is_no_set_is_refused_in_one_line(tmp_path):
    with pytest.raises(ImagesError, match="holds no labelled images; valid: "):
        LabelledImages(tmp_path)
    with pytest.raises(ImagesError, match="is missing; valid: "):
        DetectionImages(tmp_path)


def test_a_damaged_shard_is_named(folder, tmp_path):
    entry = read_manifest(folder).shards[0]
    (tmp_path / "shards").mkdir()
    (tmp_path / "manifest.json").write_bytes((folder / "manifest.json").read_bytes())
    (tmp_path / entry.file).write_bytes((folder / entry.file).read_bytes()[:2000])
    with pytest.raises(ImagesError, match=r"images-000000\.tar"):
        LabelledImages(tmp_path).facts(0)


def test_opening_a_set_loads_no_torch(folder):
    code = (
        "import sys; from scenarios.images.datasets import DetectionImages, LabelledImages\n"
        f"LabelledImages({str(folder)!r}); DetectionImages({str(folder)!r})\n"
        "print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_normals_and_flow_survive_their_images():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(20, 30, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals[0] = 0.0
    np.testing.assert_allclose(normals_of(_normal_pixels(normals)), normals, atol=0.008)
    flow = rng.uniform(-511, 511, (20, 30, 2))
    kind = rng.integers(0, 3, (20, 30)).astype(np.uint8)
    flow[kind == 0] = 0.0
    back, kind_back = flow_of(_flow_pixels(flow, kind))
    np.testing.assert_array_equal(kind_back, kind)
    np.testing.assert_allclose(back, flow, atol=0.5 / 64 + 1e-4)
