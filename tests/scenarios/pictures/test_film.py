"""Films are written whole or not at all."""

import numpy as np
import pytest

from scenarios.pictures.film.encode import write_animation, write_video
from tests.full_disk import files_end_after


def pictures(count):
    draw = np.random.default_rng(0)
    for _ in range(count):
        yield draw.integers(0, 255, (96, 128, 3), dtype=np.uint8)


@pytest.mark.parametrize("name", ["film.mp4", "film.webm", "film.gif"])
def test_a_film_that_a_full_disk_cuts_short_is_an_error_and_no_file(tmp_path, capfd, name):
    write = write_animation if name.endswith(".gif") else write_video
    write(pictures(8), 10.0, tmp_path / name)
    n_bytes = (tmp_path / name).stat().st_size
    (tmp_path / name).unlink()
    capfd.readouterr()
    for limit in (0, n_bytes // 2, n_bytes - 1000):
        with (
            files_end_after(limit),
            pytest.raises(OSError),  # noqa: PT011 - each encoder has words of its own
        ):
            write(pictures(8), 10.0, tmp_path / name)
        assert list(tmp_path.iterdir()) == []
