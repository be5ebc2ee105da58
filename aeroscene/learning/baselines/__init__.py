"""Other projects' methods of making scenes, re-implemented from their papers to compare ours with.

None of these is its authors' code. Each learns from the same scenes as ours, in one interface:
`named.fit` trains a method within a budget, and what it returns draws scenes by seed.
"""
