"""What `aeroscene campaign` reports on standard error while trials come in."""

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


class CampaignNews:
    """Reports the first failure of each code at once, and how far the campaign is.

    A pilot that raises in its first trial raises in all of them. The user should read that after
    one trial, not after the last.
    """

    def __init__(
        self, folder: Path, n_left: int, outcomes: Iterable[bool | None], *, has_bar: bool
    ) -> None:
        """Begin.

        Args:
            folder: Folder of the campaign.
            n_left: Number of trials that are to be flown.
            outcomes: Success of the trials that are in the folder already.
            has_bar: Whether a progress bar is shown, so that lines of progress are not needed.
        """
        self._folder = folder
        self._n_left = n_left
        self._outcomes = Counter(outcomes)
        self._has_bar = has_bar
        self._codes: Counter[str] = Counter()
        self._has_hinted = False
        self._period = min(max(1, n_left // _LINES), _MOST_PERIOD)

    def add(self, row: Row, advance: Advance) -> None:
        """Take in a trial that has ended."""
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
        n_judged = self._outcomes[True] + self._outcomes[False]
        return f"{self._outcomes[True] / n_judged:.1%}" if n_judged else "none"


def fly_command(folder: Path, row: Mapping[str, object]) -> str:
    """Command that flies a trial of a campaign again, with a recording."""
    words = ("--scene", row["scene"], "--vehicle", row["vehicle"], "--trial", row["trial"])
    return shell("aeroscene", "fly", "--out", folder, *map(str, words))


def _say(text: str) -> None:
    # Not by a terminal of rich's, which breaks lines; a bar that is shown moves below the line.
    sys.stderr.write(f"{_PROG}: {' '.join(text.split())}\n")
    sys.stderr.flush()
