"""`aeroscene`: everything but the testbench itself."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import tyro

from scenarios.cli import bench, compile, doctor, export, replay  # noqa: A004 - the command's name
from scenarios.cli.command_line import EXIT_INTERRUPTED, fail, parse
from scenarios.sitl import INPUT_ERRORS

PROG = "aeroscene"

Command = (
    Annotated[replay.ReplayCfg, tyro.conf.subcommand("replay")]
    | Annotated[doctor.DoctorCfg, tyro.conf.subcommand("doctor")]
    | Annotated[bench.BenchCfg, tyro.conf.subcommand("bench")]
    | Annotated[compile.CompileCfg, tyro.conf.subcommand("compile")]
    | Annotated[export.ExportCfg, tyro.conf.subcommand("export")]
)

_RUN: Mapping[type, Callable[[Any], int]] = {
    replay.ReplayCfg: replay.run,
    doctor.DoctorCfg: doctor.run,
    bench.BenchCfg: bench.run,
    compile.CompileCfg: compile.run,
    export.ExportCfg: export.run,
}


def main(args: list[str] | None = None) -> int:
    """Run the command; returns the exit status."""
    logging.basicConfig(level=logging.WARNING, format=f"{PROG}: %(message)s", stream=sys.stderr)
    command = parse(Command, PROG, args)
    try:
        return _RUN[type(command)](command)
    except INPUT_ERRORS as error:
        fail(PROG, str(error))
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
