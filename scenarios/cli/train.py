"""`aeroscene train`: a model that generates scenes, trained step by step."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from aeroscene.processes import default_jobs
from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_INTERRUPTED,
    default_hint,
    fail,
    fail_on_file,
    handling_signals,
    print_json,
)
from scenarios.cli.progress import progress_bar
from scenarios.cli.training_bar import TrainingBar, training_bar

if TYPE_CHECKING:
    from aeroscene.learning.training.checkpoint import Part
    from aeroscene.learning.training.data import TrainingData
    from aeroscene.learning.training.procedure import Plan, Training
    from aeroscene.learning.training.state import TrainingState

_PROG = "aeroscene train"


@dataclass(frozen=True, kw_only=True)
class TrainCfg:
    """Train a model that generates scenes: first what writes them, then what places it.

    Ctrl-C saves and leaves; the same command with --resume goes on from there. The folder then
    holds checkpoint.safetensors for `aeroscene generate`, state.safetensors to go on from,
    log.jsonl and curves.png.
    """

    preset: Annotated[Literal["default", "paper"] | None, default_hint("default")] = None
    """Model and training: default is ours, paper follows the paper to the letter."""
    config: Annotated[Path | None, default_hint("none")] = None
    """TOML file that changes fields of the preset; see docs/model.md."""
    data: Path = Path("corpus")
    """Folder that `aeroscene dataset build` has made, or a file of neutral layouts."""
    stream: bool = False
    """Go on beyond the folder's last scene: processes make scene after scene while the network
    learns. The folder's training scenes fix vocabulary and statistics, its test scenes are held
    out."""
    workers: Annotated[int | None, default_hint("cores less one with --stream, at least 1")] = None
    """Number of processes that make scenes for --stream; the weights do not depend on it."""
    out: Path = Path("training")
    """Folder to write to; it is made where there is none."""
    steps: Annotated[int | None, default_hint("no limit")] = None
    """Training steps of writer and denoiser each; the weights do not depend on whether the training
    was resumed."""
    minutes: Annotated[float | None, default_hint("60 without --steps")] = None
    """Minutes of training, half for the writer and half for the denoiser, or all for the one
    that is trained; it ends at steps or minutes, whichever comes first."""
    resume: bool = False
    """Continue the training in the folder."""
    device: str = "auto"
    """auto takes a GPU where there is one; or cpu, cuda, cuda:1, mps."""
    threads: Annotated[int | None, default_hint("all cores")] = None
    """Number of CPU threads."""
    parts: Annotated[
        tuple[Literal["writer", "prior", "denoiser"], ...] | None,
        default_hint("all of these", metavar="{writer,prior,denoiser} ..."),
    ] = None
    """Parts of the model to train. The default preset has writer and denoiser, paper has prior (a
    minute) and denoiser."""
    take: Annotated[Path | None, default_hint("none")] = None
    """Checkpoint from which the parts that are not trained are copied; it must be of the same
    data."""
    save_minutes: float = 5.0
    """Minutes between two saves."""
    json: bool = False
    """Print one JSON object: folder, checkpoint, preset, device, done, and figures of the
    training."""


def run(cfg: TrainCfg) -> int:
    """Train; exit status 2 with one line where input, device or memory do not allow it."""
    from aeroscene.learning import require_torch  # noqa: PLC0415
    from aeroscene.scene import SceneError  # noqa: PLC0415

    try:
        require_torch()
        # Imported here because PyTorch takes seconds that no other command should spend.
        from aeroscene.learning.training.procedure import Training  # noqa: PLC0415

        with _asked_to_stop() as stop:
            state = _open_state(cfg)
            plan = _plan(cfg, state)
            _mention_shortfall(cfg.data)
            with training_bar() as bar:
                training = Training(plan, _Watcher(bar, stop))
                is_done = training.run(state)
    except SceneError as error:
        fail(_PROG, str(error))
    except OSError as error:
        fail_on_file(_PROG, error)
    _report(cfg, plan, training, is_done=is_done)
    return EXIT_DONE if is_done else EXIT_INTERRUPTED


@dataclass(frozen=True)
class _Watcher:
    """Moves the progress bar, and stops the training when the user asks for it."""

    bar: TrainingBar
    stop: threading.Event

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        self.bar.show(stage, share, figures)

    def wants_stop(self) -> bool:
        return self.stop.is_set()


@contextmanager
def _asked_to_stop() -> Iterator[threading.Event]:
    """Yield an event that SIGINT or SIGTERM sets; a second one ends the process at once."""
    event = threading.Event()

    def ask(number: int, _frame: Any) -> None:
        event.set()
        signal.signal(number, signal.default_int_handler)

    with handling_signals(ask):
        yield event


def _open_state(cfg: TrainCfg) -> TrainingState | None:
    from aeroscene.learning.training.config import TrainingError  # noqa: PLC0415 - PyTorch
    from aeroscene.learning.training.state import STATE, read_state  # noqa: PLC0415

    state = read_state(cfg.out / STATE)
    if state is not None and not cfg.resume:
        raise TrainingError(
            f"out {str(cfg.out)!r} holds a training already ({state.steps:,} steps in all), "
            "valid: --resume to go on with it, or another folder"
        )
    if state is None and cfg.resume:
        raise TrainingError(
            f"out {str(cfg.out)!r} holds no training to resume ({STATE} is missing), "
            "valid: a folder that aeroscene train has written to"
        )
    return state


def _plan(cfg: TrainCfg, state: TrainingState | None) -> Plan:
    import torch  # noqa: PLC0415 - seconds that no other command should spend

    from aeroscene.learning.training.config import require  # noqa: PLC0415
    from aeroscene.learning.training.devices import choose_device  # noqa: PLC0415
    from aeroscene.learning.training.presets import PARTS, fitted, part_budgets  # noqa: PLC0415
    from aeroscene.learning.training.procedure import Plan  # noqa: PLC0415
    from aeroscene.learning.training.same_data import taken_parts  # noqa: PLC0415

    device = choose_device(cfg.device)
    n_workers = _n_workers(cfg)
    if cfg.threads is not None:
        require(ok=1 <= cfg.threads <= 1024, name="threads", value=cfg.threads, valid="1 to 1024")
        torch.set_num_threads(cfg.threads)
    least = "more than 0"
    require(ok=cfg.save_minutes > 0, name="save_minutes", value=cfg.save_minutes, valid=least)
    minutes = 60.0 if cfg.minutes is None and cfg.steps is None else cfg.minutes
    # Refuse bad options before reading the scenes, which takes time.
    preset, sections = _sections(cfg, state)
    parts = cfg.parts or PARTS[preset]
    strange = [part for part in parts if part not in PARTS[preset]]
    valid = f"{', '.join(PARTS[preset])} with preset {preset}"
    require(ok=not strange, name="parts", value=" ".join(parts), valid=valid)
    budgets = part_budgets(parts, cfg.steps, minutes)
    is_streamed = cfg.stream or (state is not None and state.facts.data.stream != "")
    data = _read_data(cfg.data, sections, is_streamed=is_streamed)
    if state is None:
        sections = fitted(sections, data.train.known)
    return Plan(
        folder=cfg.out,
        preset=preset,
        sections=sections,
        data=data,
        budgets=budgets,
        device=device,
        save_seconds=60.0 * cfg.save_minutes,
        parts=parts,
        n_workers=n_workers,
        taken={} if cfg.take is None else taken_parts(cfg.take, data, parts),
    )


def _n_workers(cfg: TrainCfg) -> int:
    from aeroscene.learning.training.config import TrainingError, require  # noqa: PLC0415 - PyTorch

    if cfg.workers is None:
        return max(1, default_jobs() - 1)
    require(ok=1 <= cfg.workers <= 512, name="workers", value=cfg.workers, valid="1 to 512")
    if not (cfg.stream or cfg.resume):
        raise TrainingError(f"workers is {cfg.workers} without --stream, valid: with it, or none")
    return cfg.workers


def _sections(cfg: TrainCfg, state: TrainingState | None) -> tuple[Any, dict[str, Any]]:
    """Preset and sections of the configuration; on resuming, those of the training so far."""
    from aeroscene.learning.training.presets import (  # noqa: PLC0415 - PyTorch
        preset_sections,
        sections_from_plain,
    )
    from aeroscene.learning.training.settings import read_settings  # noqa: PLC0415

    if state is None:
        preset = cfg.preset or "default"
        sections = preset_sections(preset)
        if cfg.config is not None:
            sections = read_settings(cfg.config, sections)
        return preset, sections
    sections = sections_from_plain(state.facts.configs)
    _check_unchanged(cfg, state, sections)
    return state.facts.preset, sections


def _check_unchanged(cfg: TrainCfg, state: TrainingState, sections: Mapping[str, Any]) -> None:
    from aeroscene.learning.training.config import TrainingError  # noqa: PLC0415 - PyTorch
    from aeroscene.learning.training.settings import read_settings  # noqa: PLC0415

    begun = state.facts.preset
    if cfg.preset not in {None, begun}:
        raise TrainingError(
            f"preset is {cfg.preset!r}, valid: {begun!r}, with which the training in "
            f"{str(cfg.out)!r} was begun; or another folder"
        )
    if cfg.config is None:
        return
    asked = read_settings(cfg.config, sections)
    different = [name for name in sections if asked[name] != sections[name]]
    if different:
        raise TrainingError(
            f"config {str(cfg.config)!r} is not what the training in {str(cfg.out)!r} was begun "
            f"with ([{different[0]}] differs), valid: the same, none, or another folder"
        )


def _read_data(path: Path, sections: Mapping[str, Any], *, is_streamed: bool) -> TrainingData:
    from aeroscene.learning.training.data import (  # noqa: PLC0415 - PyTorch
        count_scenes,
        is_layouts,
        open_training_data,
    )
    from aeroscene.learning.training.presets import is_flat  # noqa: PLC0415

    title = "mapping layouts" if is_layouts(path) else "reading scenes"
    with progress_bar(title, count_scenes(path)) as advance:
        return open_training_data(
            path,
            is_flat=is_flat(sections),
            is_streamed=is_streamed,
            on_scene=advance,
        )


def _mention_shortfall(path: Path) -> None:
    from aeroscene.learning.training.data import is_layouts  # noqa: PLC0415 - PyTorch
    from scenarios.cli.dataset.options import mention_shortfall  # noqa: PLC0415 - heavy

    if not is_layouts(path):
        mention_shortfall(_PROG, path)


def _report(cfg: TrainCfg, plan: Plan, training: Training, *, is_done: bool) -> None:
    from aeroscene.learning.training.procedure import CHECKPOINT  # noqa: PLC0415 - PyTorch

    path = plan.folder / CHECKPOINT
    figures = training.figures
    if cfg.json:
        facts = {
            "folder": str(plan.folder),
            "checkpoint": str(path),
            "preset": plan.preset,
            "device": str(plan.device),
            "done": is_done,
        }
        print_json(facts | figures)
        return
    said = "; ".join(_said(part, figures) for part in training.trainings)
    said = said or f"parts {', '.join(training.parts)}"
    print(f"{path}: {said}")
    if not is_done:
        sys.stderr.write(f"{_PROG}: stopped and saved; --resume goes on from here\n")


def _said(part: Part, figures: Mapping[str, Any]) -> str:
    """How long a part was trained, and to which losses."""
    from aeroscene.learning.training.course import figure_prefix  # noqa: PLC0415 - PyTorch

    prefix = figure_prefix(part)
    names = [name for name in ("loss", "held_out_loss") if prefix + name in figures]
    losses = ", ".join(f"{name.replace('_', ' ')} {figures[prefix + name]:.4f}" for name in names)
    minutes = figures[f"{prefix}seconds"] / 60
    said = f"{part} {figures[f'{prefix}steps']:,} steps in {minutes:.1f} min, {losses}"
    if f"{prefix}held_out_least" not in figures:
        return said
    least, step = figures[f"{prefix}held_out_least"], figures[f"{prefix}held_out_least_step"]
    return f"{said} (least {least:.4f} at step {step:,})"
