"""Fixed suites: trials that ship by name, so that everybody's figures are of the same tasks."""

from scenarios.campaigns.fixed.suite import (
    FixedSuite,
    FixedSuiteError,
    families,
    fixed_suite,
    fixed_suites,
    named_recipe,
)

__all__ = [
    "FixedSuite",
    "FixedSuiteError",
    "families",
    "fixed_suite",
    "fixed_suites",
    "named_recipe",
]
