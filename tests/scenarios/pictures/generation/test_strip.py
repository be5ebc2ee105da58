import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenarios.pictures.generation.strip import N_MOMENTS, chosen_steps, draw_strip, layout_of
from tests.aeroscene.conftest import cached_scene


@given(st.integers(1, 1000))
def test_first_and_last_step_are_drawn_and_none_twice(n_steps):
    steps = chosen_steps(n_steps)
    assert steps[0] == 0
    assert steps[-1] == n_steps - 1
    assert list(steps) == sorted(set(steps))
    assert len(steps) <= N_MOMENTS


def test_strip_has_a_picture_for_each_moment_and_two_for_the_scene(tmp_path):
    scene = cached_scene(42)
    layout = layout_of(scene)
    assert len(layout.size_m) == len(scene.objects)
    assert layout.is_coarse.sum() == sum(obj.is_coarse for obj in scene.objects)
    moments = [("t = 1.00 T", layout), ("t = 0", layout)]
    widths = {}
    for name, finished in (("rejected", None), ("finished", scene)):
        path = tmp_path / f"{name}.png"
        draw_strip(moments, 45.0, finished, path)
        widths[name] = cv2.imread(str(path)).shape[1]
    assert widths["rejected"] < widths["finished"]
    strip = cv2.imread(str(tmp_path / "finished.png")).astype(int)
    # Equal layouts give equal pictures; the titles above differ.
    np.testing.assert_array_equal(strip[40:330, 10:310], strip[40:330, 320:620])
    np.testing.assert_array_equal(strip[40:330, 10:310], strip[40:330, 630:930])
    # The legend below has the colours of the boxes: blue for coarse ones, orange for fine ones.
    blue, green, red = np.moveaxis(strip[-44:], 2, 0)
    assert (blue - red > 10).any()
    assert (red - blue > 60).any()
    assert (np.abs(blue - green) < 12).mean() > 0.5
