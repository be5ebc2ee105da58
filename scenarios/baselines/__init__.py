"""Pilots that ship beside ours, as baselines to tell flight stacks apart by."""
