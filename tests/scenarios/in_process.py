"""The command line within the test's own process."""

import pytest

from scenarios.cli.main import main


def in_process(capsys: pytest.CaptureFixture[str], *args: object) -> tuple[object, str, str]:
    """Run `aeroscene` with these arguments: its exit status, standard output, standard error."""
    try:
        status: object = main([str(arg) for arg in args])
    except SystemExit as stop:
        status = stop.code
    output = capsys.readouterr()
    return status, output.out, output.err
