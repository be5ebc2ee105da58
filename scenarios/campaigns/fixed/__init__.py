"""Fixed suites: trials that ship by name, so that everybody's figures are of the same tasks."""

from scenarios.campaigns.fixed.suite import FixedSuite, FixedSuiteError, fixed_suite, fixed_suites

__all__ = ["FixedSuite", "FixedSuiteError", "fixed_suite", "fixed_suites"]
