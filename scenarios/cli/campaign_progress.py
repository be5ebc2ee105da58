"""News of a running campaign on standard error: progress, and the first failure of each code."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from scenarios.cli.progress import Advance
from scenarios.cli.terminal import shell

if TYPE_CHECKING:
    from scenarios.campaigns.flyer import Row

_PROG = "aeroscene campaign"
_LINES = 20
"""Progress lines of a campaign where there is no terminal, unless that leaves long silences."""
_MOST_PERIOD = 100
"""Most trials between two progress lines."""


class CampaignProgress:
    """Reports the first failure of each code at once, and how far the campaign is.

    A pilot that raises in its first trial raises in all of them. The user should read that after
    one trial, not after the last.
    """

    def __init__(
        self, folder: Path, n_left: int, outcomes: Iterable[bool | None], *, has_bar: bool
    ) -> None:
        """Start with no trial of this run flown.

        Args:
            folder: Folder of the campaign.
            n_left: Number of trials that are to be flown.
            outcomes: Success of the trials that are in the folder already.
            has_bar: True if a progress bar is shown, so that lines of progress are not needed.
        """
        self._folder = folder
        self._n_left = n_left
        self._outcomes = Counter(outcomes)
        self._has_bar = has_bar
        self._codes: Counter[str] = Counter()
        self._has_hinted = False
        # A log file of a long campaign must not be silent for hours, hence the upper limit.
        self._period = min(max(1, n_left // _LINES), _MOST_PERIOD)

    def add(self, row: Row, advance: Advance) -> None:
        """Count a trial that has ended, move the bar, and print what is worth a line.

        Args:
            row: Result of the trial; needs success, code, trial_id, reason, scene, vehicle, trial.
            advance: Function of the progress bar, called once.
        """
        self._outcomes[row["success"]] += 1
        self._codes[row["code"]] += 1
        if row["success"] is False and self._codes[row["code"]] == 1:
            self._report_first(row)
        advance(1, title=f"success so far {self._rate()}")
        n = self._codes.total()
        if not self._has_bar and (n % self._period == 0 or n == self._n_left):
            codes = ", ".join(f"{count} {code}" for code, count in self._codes.most_common())
            _say(f"{n} of {self._n_left} trials flown, success so far {self._rate()}; {codes}")

    def _report_first(self, row: Row) -> None:
        _say(f"first trial that is {row['code']}: {row['trial_id']}: {row['reason']}")
        if not self._has_hinted:
            self._has_hinted = True
            _say(f"to fly it again and record it: {fly_command(self._folder, row)}")

    def _rate(self) -> str:
        # Trials without a task have no success (None), and count neither way.
        n_judged = self._outcomes[True] + self._outcomes[False]
        return f"{self._outcomes[True] / n_judged:.1%}" if n_judged else "none"


def fly_command(folder: Path, row: Mapping[str, object]) -> str:
    """Return the shell command that flies a trial of a campaign again, with a recording.

    Args:
        folder: Folder of the campaign.
        row: Result of the trial; needs scene, vehicle and trial.
    """
    words = ("--scene", row["scene"], "--vehicle", row["vehicle"], "--trial", row["trial"])
    return shell("aeroscene", "fly", "--out", folder, *map(str, words))


def _say(text: str) -> None:
    # Plain write, because rich would break long lines. A visible bar moves below the line.
    sys.stderr.write(f"{_PROG}: {' '.join(text.split())}\n")
    sys.stderr.flush()
