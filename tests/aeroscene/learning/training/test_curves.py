import math
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from aeroscene.learning.training.curves import CURVES, draw_curves
from aeroscene.learning.training.journal import append_line

BLUE = (31, 119, 180)


def write(folder, values, stage="denoiser"):
    for step, value in enumerate(values, 1):
        append_line(folder, {"stage": stage, "step": step, "total": value})


def rows_of(folder, colour, columns=slice(90, 750)):
    with Image.open(folder / CURVES) as file:
        picture = np.asarray(file.convert("RGB")).astype(int)
    is_line = (np.abs(picture - colour).sum(axis=2) < 60)[:, columns]
    return [np.flatnonzero(column).mean() for column in is_line.T if column.any()]


def height_of(folder):
    with Image.open(folder / CURVES) as file:
        return file.height


def test_nothing_is_drawn_of_nothing(tmp_path):
    assert not draw_curves(tmp_path)
    write(tmp_path, [1.0])
    assert not draw_curves(tmp_path)
    assert not (tmp_path / CURVES).exists()


def test_falling_loss_falls_in_the_picture(tmp_path):
    write(tmp_path, [2.0 * math.exp(-step / 20) for step in range(100)])
    assert draw_curves(tmp_path)
    rows = rows_of(tmp_path, BLUE)
    assert len(rows) > 300
    assert all(b >= a - 2.0 for a, b in pairwise(rows))
    assert rows[-1] - rows[0] > 200


def test_each_stage_has_a_panel_of_its_own(tmp_path):
    write(tmp_path, [3.0, 2.0, 1.0], "writer")
    draw_curves(tmp_path)
    one = height_of(tmp_path)
    write(tmp_path, [3.0, 2.0, 1.0])
    draw_curves(tmp_path)
    assert height_of(tmp_path) == 2 * one


@pytest.mark.parametrize("values", [[1.0, 1.0], [1e-9, 1e9], [0.0, -1.0, 2.0, 3.0], [5e-7, 6e-7]])
def test_curves_of_any_size_fit_the_panel(tmp_path, values):
    write(tmp_path, values)
    assert draw_curves(tmp_path)
    rows = rows_of(tmp_path, BLUE)
    assert rows
    assert min(rows) > 40
    assert max(rows) < 375
