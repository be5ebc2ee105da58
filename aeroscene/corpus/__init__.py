"""Scenes: the grammar that curates the corpus, its files, and the scenes that ship."""
