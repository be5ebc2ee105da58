"""Bars: nothing of them where standard error is no terminal."""

from scenarios.cli.progress import progress_bar, share_bar


def test_bars_leave_files_and_pipes_clean(capsys):
    with share_bar() as on_progress:
        on_progress("half", 0.5)
    with progress_bar("scenes", 2) as advance:
        advance()
    output = capsys.readouterr()
    assert (output.out, output.err) == ("", "")
