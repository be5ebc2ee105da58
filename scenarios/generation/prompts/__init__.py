"""Wishes in words: a prompt is read by a parser or by a language model, and measured on scenes.

    found = read_prompt("a crowded harbour street with two cafes")
    found.theme                    # "waterfront"
    found.counts[0].thing          # "cafe"

`parsing/` reads words, and `endpoint.py` asks a language model for the same `Wishes`.
`understanding.py` joins them with the options of the command line, and `demands.py` measures them
on a scene. `things.toml` and `themes.toml` are the vocabulary.
"""
