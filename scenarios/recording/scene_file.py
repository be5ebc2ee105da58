"""A scene alone as a recording, to look at without a flight."""

from __future__ import annotations

from pathlib import Path

import rerun as rr

from aeroscene.scene import Scene
from aeroscene.solids.shapes import scene_primitives
from scenarios.recording import layout
from scenarios.recording.blueprint import scene_blueprint
from scenarios.recording.legend import AREA_ROWS, log_legend
from scenarios.recording.output import RecordingError, close_output, require_room, write_out
from scenarios.recording.scene import log_scene


def write_scene_recording(scene: Scene, path: Path) -> None:
    """Write an .rrd file that shows the scene and its interaction areas.

    Args:
        scene: Any scene.
        path: File to write; it is replaced if it exists.

    Raises:
        RecordingError: If it cannot be written.
    """
    stream = rr.RecordingStream(layout.APPLICATION_ID)
    require_room(path)
    stream.set_sinks(rr.FileSink(path), default_blueprint=scene_blueprint(scene))
    log_scene(stream, scene, scene_primitives(scene))
    log_legend(stream, AREA_ROWS)
    fault = write_out(stream, path)
    close_output(stream, fault)
    if fault is not None:
        raise RecordingError(f"recording {str(path)!r} cannot be written ({fault})")
