"""A disk that fills up under rerun's writer: an error, no file, and an end."""

import subprocess
import sys

import pytest

from tests.full_disk import LIMITED

FULL = f"""{LIMITED}
from pathlib import Path
from aeroscene.corpus.field import field_scene
from scenarios.recording import RecordingError
from scenarios.recording.scene_file import write_scene_recording

try:
    write_scene_recording(field_scene(), Path(sys.argv[1]))
except RecordingError as error:
    print(error)
"""


# The writer ends at another message each time; some are left in its queue.
@pytest.mark.parametrize("limit", [0, 100, 2_000, 8_000, 20_000])
def test_a_recording_without_room_is_an_error_and_an_end(tmp_path, limit):
    path = tmp_path / "x.rrd"
    done = subprocess.run(
        [sys.executable, "-B", "-c", FULL, str(limit), str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"recording '{path}' cannot be written (")
    assert not path.exists()
