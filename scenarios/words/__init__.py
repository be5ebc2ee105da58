"""Goals in words: texts that name exactly one place of a scene, and the check that they do.

A text is never parsed. `drawing` draws a `goal.Description`, a small tree of kinds, looks and
relations. `fitting` evaluates it on the `site`, and `phrasing` writes it in English afterwards. The
meaning of a text is therefore known exactly. docs/goals.md describes goals to users.
"""
