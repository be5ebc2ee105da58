"""`python -m aeroscene`: the command line, from a package that depends on this one."""

import sys

from scenarios.cli.entry import aeroscene

sys.exit(aeroscene())
