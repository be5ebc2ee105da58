"""Scenes: the grammar that curates the corpus, the files of it, and the scenes that ship."""
