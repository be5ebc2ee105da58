"""`aeroscene dataset`: count, check, look at and unpack scenes, and build the corpus."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import tyro

from aeroscene.processes import WorkerDiedError
from aeroscene.scene import SceneError
from scenarios.cli.boundary import of_file
from scenarios.cli.command_line import fail
from scenarios.cli.dataset import build, show, stats, unpack, validate
from scenarios.cli.dataset.options import mention_part
from scenarios.cli.scene_numbers import SceneNumbersError

Action = (
    Annotated[build.BuildCfg, tyro.conf.subcommand("build", prefix_name=False)]
    | Annotated[stats.StatsCfg, tyro.conf.subcommand("stats", prefix_name=False)]
    | Annotated[validate.ValidateCfg, tyro.conf.subcommand("validate", prefix_name=False)]
    | Annotated[show.ShowCfg, tyro.conf.subcommand("show", prefix_name=False)]
    | Annotated[unpack.UnpackCfg, tyro.conf.subcommand("unpack", prefix_name=False)]
)

_RUN: Mapping[type, Callable[[Any], int]] = {
    build.BuildCfg: build.run,
    stats.StatsCfg: stats.run,
    validate.ValidateCfg: validate.run,
    show.ShowCfg: show.run,
    unpack.UnpackCfg: unpack.run,
}


@dataclass(frozen=True, kw_only=True)
class DatasetCfg:
    """Count, check, look at and unpack the 1,016 scenes that ship, or those of a folder.

    build makes such a folder, with the training corpus in it.
    """

    action: Action


def run(cfg: DatasetCfg) -> int:
    """Run the subcommand, and mention a corpus that is incomplete.

    Returns:
        Exit status of the subcommand. Bad input or an unusable folder ends the process with status
        2 and one line.
    """
    prog = f"aeroscene dataset {type(cfg.action).__module__.rpartition('.')[2]}"
    action = cfg.action
    try:
        status = _RUN[type(action)](action)
        # After the work, so that the remark is not lost above a long table.
        if isinstance(action, stats.StatsCfg | validate.ValidateCfg | show.ShowCfg):
            mention_part(action.data, action.scenes)
    except (SceneError, SceneNumbersError, WorkerDiedError) as error:
        fail(prog, str(error))
    except OSError as error:
        fail(prog, of_file(error))
    return status
