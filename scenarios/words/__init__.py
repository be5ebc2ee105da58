"""Goals in words: texts that name exactly one place of a scene, and the check that they do.

A text is never parsed. `goal_drawing` draws a `goal.Description`, a small tree of kinds, looks and
relations. `grounding` evaluates it on the `site`, and `description_text` writes it in English
afterwards. The meaning of a text is therefore known exactly. docs/goals.md describes goals to
users.
"""
