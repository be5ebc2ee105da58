from PIL import Image

from scenarios.evaluation.curves import draw_learning_curves

LOSSES = [(60.0, 3.0), (120.0, 1.0), (180.0, 2.0)]


def test_each_training_has_a_panel_of_its_own(tmp_path):
    sizes = {}
    for n in (1, 3, 4):
        path = tmp_path / f"{n}.png"
        assert draw_learning_curves(path, {f"method {k}": LOSSES for k in range(n)})
        with Image.open(path) as picture:
            sizes[n] = picture.size
    assert sizes[3] == (3 * sizes[1][0], sizes[1][1])
    assert sizes[4] == (sizes[3][0], 2 * sizes[3][1])


def test_without_two_looks_there_is_no_curve(tmp_path):
    path = tmp_path / "curves.png"
    assert not draw_learning_curves(path, {"method": LOSSES[:1]})
    assert not path.exists()
