"""The command `aeroscene` and its subcommands."""

from __future__ import annotations

import functools
import importlib
import operator
import sys
from collections.abc import Mapping
from typing import Annotated, Any

import tyro

from scenarios.cli.command_line import execute, parse

PROG = "aeroscene"
_COMMANDS: Mapping[str, str] = {
    "sitl": "SitlCommand",
    "fly": "FlyCfg",
    "campaign": "CampaignCfg",
    "report": "ReportCfg",
    "compare": "CompareCfg",
    "new": "NewCfg",
    "replay": "ReplayCfg",
    "doctor": "DoctorCfg",
    "dataset": "DatasetCfg",
    "images": "ImagesCfg",
    "bench": "BenchCfg",
    "compile": "CompileCfg",
    "export": "ExportCfg",
    "export-trial": "ExportTrialCfg",
    "layouts": "LayoutsCfg",
    "generate": "GenerateCfg",
    "train": "TrainCfg",
    "evaluate": "EvaluateCfg",
}
"""Name of the options' class in the module of each command, which is imported on demand."""


def main(args: list[str] | None = None) -> int:
    """Run a command, or print the help without one.

    Args:
        args: Words of the command line; None takes those of the process.

    Returns:
        The exit status of the command.
    """
    args = sys.argv[1:] if args is None else args
    # The first word decides, so that one command's module is imported and not all of them.
    name = args[0] if args else ""
    if name in _COMMANDS:
        module = _module(name)
        return execute(getattr(module, _COMMANDS[name]), module.run, f"{PROG} {name}", args[1:])
    parse(_any_command(), PROG, args, "A drone flight-stack testbench; --version says which.")
    return 0


def _module(name: str) -> Any:
    return importlib.import_module(f"scenarios.cli.{name.replace('-', '_')}")


def _any_command() -> Any:
    """Return the union of all commands, for the list in the help and for suggestions."""
    commands = (
        Annotated[Any, tyro.conf.subcommand(name, constructor=getattr(_module(name), options))]
        for name, options in _COMMANDS.items()
    )
    return functools.reduce(operator.or_, commands)


if __name__ == "__main__":
    sys.exit(main())
