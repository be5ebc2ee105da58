"""The training that the options of `aeroscene train` ask for.

Options are checked in two passes. `require_usable` refuses everything that it can without PyTorch,
which takes seconds to load. `training_plan` then opens device, data and weights. When a training is
resumed, its preset and configuration come from the saved state, and options may not contradict it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from aeroscene.processes import default_jobs
from scenarios.cli.progress import progress_bar
from scenarios.cli.train_options import TrainCfg

if TYPE_CHECKING:
    from aeroscene.learning.training.carried import Begun
    from aeroscene.learning.training.checkpoint import Weights
    from aeroscene.learning.training.checkpoint_facts import CheckpointFacts, Part
    from aeroscene.learning.training.config import Preset
    from aeroscene.learning.training.data import TrainingData
    from aeroscene.learning.training.procedure import Plan
    from aeroscene.learning.training.state_head import StateHead
    from aeroscene.learning.writer.language import Language

_PROG = "aeroscene train"


def require_usable(cfg: TrainCfg) -> StateHead | None:
    """Refuse options and files that cannot be used, before PyTorch is loaded.

    Args:
        cfg: Options of the command.

    Returns:
        Head of the saved training in the folder, None for a new training.

    Raises:
        SceneError: If one of them cannot be used.
    """
    from aeroscene.learning.training.data_named import require_data
    from aeroscene.learning.training.network_sizes import require_trainable
    from aeroscene.learning.training.presets import read_sections

    head = _open_head(cfg.out, resumes=cfg.resume)
    _n_workers(cfg)
    preset, sections = _sections(cfg, head)
    require_trainable(sections)
    _parts(cfg, preset)
    if cfg.take is not None:
        read_sections(cfg.take)
    if cfg.begin is not None and cfg.begin != "shipped":
        read_sections(Path(cfg.begin), any_catalogue=not cfg.keep_language)
    require_data(cfg.data)
    return head


def _open_head(folder: Path, *, resumes: bool) -> StateHead | None:
    from aeroscene.learning.training.config import TrainingError
    from aeroscene.learning.training.state_head import STATE, read_head

    head = read_head(folder / STATE)
    if head is not None and not resumes:
        raise TrainingError(
            f"out {str(folder)!r} holds a training already ({head.steps:,} steps in all); "
            "valid: --resume to go on with it, or another folder"
        )
    if head is None and resumes:
        raise TrainingError(
            f"out {str(folder)!r} holds no training to resume ({STATE} is missing); "
            "valid: a folder that aeroscene train has written to"
        )
    return head


def training_plan(cfg: TrainCfg, head: StateHead | None) -> Plan:
    """Return the plan of a training, for options that `require_usable` has accepted.

    Args:
        cfg: Options of the command.
        head: Result of `require_usable`.

    Raises:
        SceneError: If options, data or device cannot be used.
    """
    import torch

    from aeroscene.learning.training.devices import choose_device
    from aeroscene.learning.training.fitted import fitted
    from aeroscene.learning.training.presets import part_budgets
    from aeroscene.learning.training.procedure import Plan

    device = choose_device(cfg.device)
    n_workers = _n_workers(cfg)
    if cfg.threads is not None:
        torch.set_num_threads(cfg.threads)
    minutes = 60.0 if cfg.minutes is None and cfg.steps is None else cfg.minutes
    preset, sections = _sections(cfg, head)
    parts = _parts(cfg, preset)
    budgets = part_budgets(parts, cfg.steps, minutes)
    # A resumed training stays on its stream, also without --stream.
    is_streamed = cfg.stream or (head is not None and head.facts.data.stream != "")
    begun = _begun_with(cfg, preset, sections)
    language = _language_of(begun) if cfg.keep_language else None
    data = _read_data(cfg.data, preset, is_streamed=is_streamed, language=language)
    # Sizes that follow from the data, such as that of the vocabulary; a saved training has them.
    if head is None:
        sections = fitted(sections, data.train.known)
    first = _first_weights(begun, data, sections)
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
        begun=first,
        taken=_taken(cfg, parts, data, first),
    )


def _begun_with(cfg: TrainCfg, preset: Preset, sections: Mapping[str, Any]) -> Begun | None:
    """Return the model whose weights the parts begin with, None for random weights."""
    from aeroscene.learning.generation.loading import SHIPPED
    from aeroscene.learning.training.carried import read_begun
    from aeroscene.learning.training.config import require
    from aeroscene.learning.training.presets import is_flat

    if cfg.begin is None:
        valid = "with --begin, whose language it is"
        require(ok=not cfg.keep_language, name="keep_language", value=True, valid=valid)
        return None
    valid = f"without it with preset {preset}, which has no language"
    is_kept = cfg.keep_language
    require(ok=not (is_kept and is_flat(sections)), name="keep_language", value=True, valid=valid)
    path = SHIPPED[preset] if cfg.begin == "shipped" else Path(cfg.begin)
    return read_begun(path, preset, any_catalogue=not is_kept)


def _language_of(begun: Begun | None) -> Language | None:
    from aeroscene.learning.writer.language import Language

    return begun.known if begun is not None and isinstance(begun.known, Language) else None


def _first_weights(
    begun: Begun | None, data: TrainingData, sections: Mapping[str, Any]
) -> dict[Part, Weights]:
    return {} if begun is None else begun.parts_for(data.train.known, sections)


def _taken(
    cfg: TrainCfg, parts: Sequence[Part], data: TrainingData, begun: Mapping[Part, Weights]
) -> dict[Part, Weights]:
    """Return the weights of the parts that are not trained."""
    from aeroscene.learning.training.same_data import taken_parts

    if cfg.take is not None:
        return taken_parts(cfg.take, data, parts)
    kept = begun if cfg.keep_language else {}
    return {part: weights for part, weights in kept.items() if part not in parts}


def _parts(cfg: TrainCfg, preset: Preset) -> tuple[Part, ...]:
    from aeroscene.learning.training.config import require
    from aeroscene.learning.training.presets import PARTS

    parts = cfg.parts or PARTS[preset]
    strange = [part for part in parts if part not in PARTS[preset]]
    valid = f"{', '.join(PARTS[preset])} with preset {preset}"
    require(ok=not strange, name="parts", value=" ".join(parts), valid=valid)
    return parts


def _n_workers(cfg: TrainCfg) -> int:
    from aeroscene.learning.training.config import TrainingError

    if cfg.workers is None:
        return max(1, default_jobs() - 1)  # One core is the network's.
    if not (cfg.stream or cfg.resume):
        raise TrainingError(f"workers is {cfg.workers} without --stream; valid: with it, or none")
    return cfg.workers


def _sections(cfg: TrainCfg, head: StateHead | None) -> tuple[Preset, dict[str, Any]]:
    """Return preset and sections of the configuration, on resuming those of the saved training."""
    from aeroscene.learning.training.presets import preset_sections, sections_from_plain
    from aeroscene.learning.training.settings import read_settings

    if head is None:
        preset = cfg.preset or "default"
        sections = preset_sections(preset)
        if cfg.config is not None:
            sections = read_settings(cfg.config, sections)
        return preset, sections
    sections = sections_from_plain(head.facts.configs)
    _check_unchanged(cfg, head.facts, sections)
    return cast("Preset", head.facts.preset), sections


def _check_unchanged(cfg: TrainCfg, facts: CheckpointFacts, sections: Mapping[str, Any]) -> None:
    from aeroscene.learning.training.config import TrainingError
    from aeroscene.learning.training.settings import read_settings

    begun = facts.preset
    if cfg.preset not in {None, begun}:
        raise TrainingError(
            f"preset is {cfg.preset!r}; valid: {begun!r}, with which the training in "
            f"{str(cfg.out)!r} was begun; or another folder"
        )
    if cfg.config is None:
        return
    # The file's changes on top of what was trained: any difference would show here.
    asked = read_settings(cfg.config, sections)
    different = [name for name in sections if asked[name] != sections[name]]
    if different:
        raise TrainingError(
            f"config {str(cfg.config)!r} is not what the training in {str(cfg.out)!r} was begun "
            f"with ([{different[0]}] differs); valid: the same, none, or another folder"
        )


def _read_data(
    path: Path, preset: Preset, *, is_streamed: bool, language: Language | None
) -> TrainingData:
    from aeroscene.learning.training.data import open_training_data
    from aeroscene.learning.training.data_named import count_scenes, is_layouts

    title = "mapping layouts" if is_layouts(path) else "reading scenes"
    with progress_bar(title, count_scenes(path)) as advance:
        return open_training_data(
            path,
            preset=preset,
            is_streamed=is_streamed,
            language=language,
            on_scene=advance,
        )


def warn_of_missing_scenes(path: Path) -> None:
    """Report on standard error how many scenes a corpus lacks, if it lacks any.

    Args:
        path: Data of the training; a file of layouts is never reported.
    """
    from aeroscene.learning.training.data_named import is_layouts
    from scenarios.cli.dataset.options import mention_shortfall

    if not is_layouts(path):
        mention_shortfall(_PROG, path)
