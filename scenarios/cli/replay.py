"""`aeroscene replay`: a recording in rerun's viewer, as pictures, as a film or as a summary."""

from __future__ import annotations

import shlex
import signal
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro
from rich.table import Table

from scenarios.cli.command_line import (
    EXIT_DONE,
    fail,
    interrupt,
    interrupt_is_answered,
    print_json,
)
from scenarios.cli.outputs import OutFile, OutFolder
from scenarios.cli.terminal import terminal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenarios.pictures import PictureFormat
    from scenarios.recording.listing import Listed
    from scenarios.recording.summary import RecordingSummary

_PROG = "aeroscene replay"


@dataclass(frozen=True, kw_only=True)
class ReplayCfg:
    """Open a recording in rerun's viewer, draw pictures of it, or print what is in it.

    A recording whose run was killed opens up to the last second that was written. For a folder,
    such as that of a campaign, the command lists the recordings in it with their verdicts.
    """

    recording: tyro.conf.Positional[Path]
    """The .rrd file, or a folder with .rrd files."""
    viewer: Literal["auto", "native", "web"] = "auto"
    """native opens a window, web serves a page on loopback; auto takes native if it can."""
    pictures: Annotated[Path | None, OutFolder(), tyro.conf.arg(help_behavior_hint="")] = None
    """Draw the planned and the flown path and the landing map into this folder instead of opening
    the viewer; needs no display."""
    formats: Annotated[tuple[Literal["png", "svg", "pdf"], ...], tyro.conf.arg(name="format")] = (
        "png",
    )
    """Format of the pictures; several may be named."""
    video: Annotated[
        Path | None,
        OutFile((".mp4", ".webm", ".webp", ".gif")),
        tyro.conf.arg(help_behavior_hint=""),
    ] = None
    """Render a film of the flight into this file instead of opening the viewer, from behind the
    vehicle and from its cameras: .mp4 or .webm to play, .webp or .gif for a page. Needs no display.
    The cameras need not have run in the flight."""
    summary: bool = False
    """Print a summary of the recording instead of opening it; needs no display."""
    json: bool = False
    """Print the summary as one JSON object."""

    def __post_init__(self) -> None:
        """Refuse an empty list of formats.

        Raises:
            ValueError: If no format is named; tyro prints it as an error of the command line.
        """
        if not self.formats:
            raise ValueError("format has no value; valid: png, svg, pdf")


def run(cfg: ReplayCfg) -> int:
    """Open, draw, film, summarise or list recordings, as the options ask.

    Returns:
        0. A file that is no recording, or a viewer that cannot open, ends the process with status 2
        and one line.
    """
    # Imported here because rerun takes time that `--help` should not spend.
    from scenarios.recording.program import RerunMissingError
    from scenarios.recording.summary import UnreadableRecordingError, summarise
    from scenarios.recording.viewer import ViewerError

    try:
        if cfg.recording.is_dir():
            _list(cfg)
        elif cfg.json or cfg.summary:
            _print_summary(summarise(cfg.recording), is_json=cfg.json)
        elif cfg.pictures is not None:
            _draw(cfg.recording, cfg.pictures, cfg.formats)
        elif cfg.video is not None:
            _film(cfg.recording, cfg.video)
        else:
            _show(cfg)
    except (UnreadableRecordingError, ViewerError, RerunMissingError) as error:
        fail(_PROG, str(error))
    return EXIT_DONE


def _list(cfg: ReplayCfg) -> None:
    """Print a line for each recording of a folder."""
    from scenarios.recording.listing import recordings_in

    folder = str(cfg.recording)
    if cfg.pictures is not None or cfg.video is not None:
        fail(_PROG, f"recording {folder!r} is a folder; valid: one of the .rrd files in it")
    found = recordings_in(cfg.recording)
    if not found:
        fail(_PROG, f"folder {folder!r} holds no recordings; valid: a folder with .rrd files")
    if cfg.json:
        print_json({"recordings": [each.to_json() for each in found]})
        return
    for each in found:
        print(_line(each))
    print(f"Open one with: aeroscene replay {shlex.quote(found[-1].recording)}")


def _line(listed: Listed) -> str:
    """Return a recording's size, verdict and task in one line."""
    line = f"{listed.recording}  {listed.size_bytes / 1e6:.1f} MB"
    if listed.code is not None:
        line += (
            f"  {listed.code}: {listed.reason}; scene {listed.scene}, {listed.vehicle}, "
            f"seed {listed.seed}, {listed.sim_seconds:.1f} s"
        )
    # Names and reasons come from files, and could hold control characters that a terminal obeys.
    return "".join(letter if letter.isprintable() else "?" for letter in line)


def _draw(recording: Path, folder: Path, formats: Sequence[PictureFormat]) -> None:
    from scenarios.pictures.recorded_story import read_story
    from scenarios.pictures.story import PictureError

    try:
        story = read_story(recording)
        # Imported here because only pictures need matplotlib.
        from scenarios.pictures.draw import draw_pictures

        for picture in draw_pictures(story, folder, formats):
            print(picture)
    except PictureError as error:
        fail(_PROG, str(error))


def _film(recording: Path, video: Path) -> None:
    # Imported here because only films need the renderer and the encoder.
    from scenarios.cli.progress import share_bar
    from scenarios.pictures import PictureError
    from scenarios.pictures.film import draw_film

    try:
        with share_bar() as on_progress:
            draw_film(recording, video, lambda n, of: on_progress("filming", n / of))
    except PictureError as error:
        fail(_PROG, str(error))
    print(video)


def _show(cfg: ReplayCfg) -> None:
    from scenarios.recording.summary import readable

    with readable(cfg.recording) as source:
        show(cfg.viewer, source, f"{cfg.recording} plays")


def show(kind: Literal["auto", "native", "web"], source: Path, what: str) -> None:
    """Open an .rrd file in a viewer until the user closes it.

    Args:
        kind: Kind of viewer; auto opens a window if there is a display, else a page.
        source: File to open.
        what: Subject and verb of the printed line that ends with the page's address.

    Raises:
        ViewerError: If the viewer cannot be opened.
        RerunMissingError: If rerun's program is not installed.
    """
    from scenarios.recording.viewer import Viewer, has_display

    # SIGTERM must end the viewer's process too, or it would outlive the command.
    signal.signal(signal.SIGTERM, interrupt)
    if kind == "auto":
        kind = "native" if has_display() else "web"
    with Viewer(kind, source) as viewer:
        try:
            if viewer.url is not None:
                print(f"{what} at {viewer.url}\nCtrl-C ends it.", flush=True)
            viewer.wait()
        except KeyboardInterrupt:
            # Ctrl-C is the usual way to close the viewer, so the status stays 0.
            interrupt_is_answered()
            sys.stderr.write("\n")


def _print_summary(summary: RecordingSummary, *, is_json: bool) -> None:
    if is_json:
        print_json(summary.to_json())
        return
    console = terminal()
    head = Table(show_header=False, box=None)
    for name, value in _headline(summary):
        head.add_row(name, value)
    console.print(head)
    parts = {"verdict": summary.verdict or {}, "rows of each entity": summary.entities}
    for title, figures in parts.items():
        if figures:
            table = Table("name", "value", title=title, title_justify="left")
            for name, value in figures.items():
                table.add_row(name, str(value))
            console.print(table)


def _headline(summary: RecordingSummary) -> list[tuple[str, str]]:
    entities = f"{len(summary.entities)} in time, {summary.static_entities} that never change"
    state = "complete" if summary.is_complete else "the run ended without closing it"
    return [
        ("recording", f"{summary.recording}, {summary.size_bytes / 1e6:.1f} MB, {state}"),
        ("scene", str(summary.scene)),
        ("vehicle", str(summary.vehicle)),
        ("seed", str(summary.seed)),
        ("simulated", f"{summary.sim_seconds:.2f} s"),
        ("entities", entities),
    ]
