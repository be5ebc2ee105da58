"""`aeroscene`: everything but the testbench itself."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import tyro

from scenarios.cli import (
    bench,
    compile,  # noqa: A004 - the command's name
    dataset,
    doctor,
    export,
    generate,
    layouts,
    replay,
    train,
)
from scenarios.cli.command_line import EXIT_INTERRUPTED, fail, parse

PROG = "aeroscene"

Command = (
    Annotated[replay.ReplayCfg, tyro.conf.subcommand("replay")]
    | Annotated[doctor.DoctorCfg, tyro.conf.subcommand("doctor")]
    | Annotated[dataset.DatasetCfg, tyro.conf.subcommand("dataset")]
    | Annotated[bench.BenchCfg, tyro.conf.subcommand("bench")]
    | Annotated[compile.CompileCfg, tyro.conf.subcommand("compile")]
    | Annotated[export.ExportCfg, tyro.conf.subcommand("export")]
    | Annotated[layouts.LayoutsCfg, tyro.conf.subcommand("layouts")]
    | Annotated[generate.GenerateCfg, tyro.conf.subcommand("generate")]
    | Annotated[train.TrainCfg, tyro.conf.subcommand("train")]
)

_RUN: Mapping[type, Callable[[Any], int]] = {
    replay.ReplayCfg: replay.run,
    doctor.DoctorCfg: doctor.run,
    dataset.DatasetCfg: dataset.run,
    bench.BenchCfg: bench.run,
    compile.CompileCfg: compile.run,
    export.ExportCfg: export.run,
    layouts.LayoutsCfg: layouts.run,
    generate.GenerateCfg: generate.run,
    train.TrainCfg: train.run,
}


def main(args: list[str] | None = None) -> int:
    """Run the command; returns the exit status."""
    logging.basicConfig(level=logging.WARNING, format=f"{PROG}: %(message)s", stream=sys.stderr)
    command = parse(Command, PROG, args)
    try:
        return _RUN[type(command)](command)
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except Exception as error:
        # The whole simulator: a second that a command without it does not spend.
        from scenarios.run.sitl import INPUT_ERRORS  # noqa: PLC0415

        if isinstance(error, INPUT_ERRORS):
            fail(PROG, str(error))
        raise


if __name__ == "__main__":
    sys.exit(main())
