"""Pilots by name: ours, those that ship as baselines to tell flight stacks apart by, one's own."""
