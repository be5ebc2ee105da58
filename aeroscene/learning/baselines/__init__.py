"""Other projects' methods of making scenes, re-implemented from their papers for comparison.

None of these is its authors' code. Each learns from the same scenes as our model, through one
interface: `registry.fit` trains a method within a budget, and the result draws scenes by seed.
"""
