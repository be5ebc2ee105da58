"""Options of `aeroscene train`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from aeroscene.ranges import THREADS, Range
from scenarios.cli.command_line import default_hint
from scenarios.cli.outputs import OutFolder

_MOST_STEPS = 1_000_000_000


@dataclass(frozen=True, kw_only=True)
class TrainCfg:
    """Train a model that generates scenes: a writer of their contents, then a denoiser of places.

    Ctrl-C saves and ends the command; run it again with --resume to continue. The folder then holds
    checkpoint.safetensors for `aeroscene generate`, state.safetensors to continue from, log.jsonl
    and curves.png.
    """

    preset: Annotated[
        Literal["default", "paper", "progressive"] | None, default_hint("default")
    ] = None
    """Model and training: default is ours, paper follows the paper to the letter."""
    config: Annotated[Path | None, default_hint("none")] = None
    """TOML file that changes fields of the preset; see docs/training.md."""
    data: Path = Path("corpus")
    """Folder made by `aeroscene dataset build`, or a file of neutral layouts."""
    stream: bool = False
    """Continue beyond the folder's last scene: processes make new scenes while the network learns.
    The folder's training scenes fix vocabulary and statistics, its test scenes are held out."""
    workers: Annotated[
        int | None, Range(1, 512), default_hint("cores less one with --stream, at least 1")
    ] = None
    """Number of processes that make scenes for --stream; the weights do not depend on it."""
    out: Annotated[Path, OutFolder()] = Path("training")
    """Folder to write to; it is made if it is missing."""
    steps: Annotated[int | None, Range(1, _MOST_STEPS), default_hint("no limit")] = None
    """Training steps of writer and denoiser each; the weights do not depend on whether the training
    was resumed."""
    minutes: Annotated[
        float | None, Range(0.0, unit="minutes", is_above=True), default_hint("60 without --steps")
    ] = None
    """Minutes of training, half for the writer and half for the denoiser, or all for the only part
    that is trained. Training ends at steps or minutes, whichever comes first."""
    resume: bool = False
    """Continue the training in the folder."""
    device: str = "auto"
    """auto takes a GPU if there is one; or cpu, cuda, cuda:1, mps."""
    threads: Annotated[int | None, THREADS, default_hint("all cores")] = None
    """Number of CPU threads."""
    parts: Annotated[
        tuple[Literal["writer", "contents", "prior", "denoiser"], ...] | None,
        default_hint("all of these", metavar="{writer,contents,prior,denoiser} ..."),
    ] = None
    """Parts of the model to train. The default preset has writer and denoiser, the paper's presets
    have contents, prior (a minute) and denoiser."""
    take: Annotated[Path | None, default_hint("none")] = None
    """Checkpoint from which the parts that are not trained are copied; it must be of the same
    data."""
    begin: Annotated[str | None, default_hint("random weights")] = None
    """Checkpoint whose weights the trained parts begin with, or `shipped` for the preset's own. A
    model of other scenes learns these in less time than random weights do."""
    keep_language: bool = False
    """Keep the kinds and statistics of --begin instead of learning them from the data, to continue
    its training with more scenes of one grammar. Parts that are not trained stay as they are
    there. Scenes with a kind that it does not know are left out."""
    save_minutes: Annotated[float, Range(0.0, unit="minutes", is_above=True)] = 5.0
    """Minutes between two saves."""
    json: bool = False
    """Print one JSON object: folder, checkpoint, preset, device, done, and figures of the
    training."""
