"""`aeroscene dataset show`: a contact sheet of scenes, or one scene in the viewer."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from aeroscene.corpus.dataset import DatasetError
from aeroscene.corpus.summary import SceneSet
from aeroscene.files.names import file_name
from aeroscene.processes import default_jobs
from aeroscene.ranges import Range
from scenarios.cli.command_line import EXIT_DONE
from scenarios.cli.dataset.options import JOBS, Data, SceneNumbers, open_scenes
from scenarios.cli.outputs import OutFile
from scenarios.cli.progress import progress_bar
from scenarios.cli.replay import show

_LARGEST_SHEET = 200
_SAMPLE = 12


@dataclass(frozen=True, kw_only=True)
class ShowCfg:
    """Draw a contact sheet of scenes, or open one of them in rerun's viewer.

    Outdoor and mixed scenes are seen from above one corner, indoor ones with the roof cut away.
    """

    data: Data = ""
    """Folder of a corpus or of scene files, or "shipped" for the scenes that come with the package;
    by default the folder corpus if there is one, else shipped."""
    scenes: SceneNumbers = ""
    """Scenes to draw: A:B without B, single ones, joined by commas; by default twelve, spread."""
    out: Annotated[Path, OutFile((".png",))] = Path("sheet.png")
    """PNG file to write."""
    columns: Annotated[int, Range(1, 50)] = 4
    """Pictures side by side."""
    width: Annotated[int, Range(80, 1920, "pixels")] = 480
    """Width of one picture; its height is three quarters of that."""
    jobs: Annotated[int, JOBS] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    viewer: Literal["off", "auto", "native", "web"] = "off"
    """Open the first of the scenes in rerun instead of drawing: native opens a window, web serves a
    page on loopback, auto takes the window if there is a display."""


def run(cfg: ShowCfg) -> int:
    """Draw the sheet, or open a scene in the viewer."""
    dataset = _choose(cfg)
    if cfg.viewer != "off":
        return _view(dataset, cfg.viewer)
    _check(cfg, dataset)
    from scenarios.pictures.sheet import draw_sheet

    with progress_bar("drawing", len(dataset.entries)) as advance:
        draw_sheet(dataset, cfg.out, cfg.columns, cfg.width, cfg.jobs, advance)
    print(f"{cfg.out}: {len(dataset.entries)} scenes")
    return EXIT_DONE


def _choose(cfg: ShowCfg) -> SceneSet[Any]:
    dataset = open_scenes(cfg.data, cfg.scenes)
    if cfg.scenes:
        return dataset
    # Datasets take the three domains in turn, so a step that three divides would show one alone.
    step = max(1, len(dataset.entries) // _SAMPLE)
    step += step % 3 == 0 and step > 1
    return dataset.select([e.index for e in dataset.entries[::step][:_SAMPLE]])


def _check(cfg: ShowCfg, dataset: SceneSet[Any]) -> None:
    if len(dataset.entries) > _LARGEST_SHEET:
        raise DatasetError(
            f"scenes {cfg.scenes!r} are {len(dataset.entries)} scenes; "
            f"valid: at most {_LARGEST_SHEET} on a sheet"
        )


# Opens the first scene; the recording is needed only as long as the viewer is open.
def _view(dataset: SceneSet[Any], viewer: Literal["auto", "native", "web"]) -> int:
    # Imported here because only this option needs rerun.
    from scenarios.recording.program import RerunMissingError
    from scenarios.recording.scene_file import write_scene_recording
    from scenarios.recording.viewer import ViewerError

    scene = dataset.read(dataset.entries[0])
    with tempfile.TemporaryDirectory(prefix="aeroscene-") as folder:
        path = Path(folder) / f"{file_name(scene.scene_id)}.rrd"
        write_scene_recording(scene, path)
        try:
            show(viewer, path, f"{scene.scene_id} is shown")
        except (ViewerError, RerunMissingError) as error:
            raise DatasetError(str(error)) from None
    return EXIT_DONE
