"""Scenes to order: requests, draws until a request is met, and scenes that are hard for a pilot.

`text_options` parses options, `prompts` reads wishes in English, `draws` draws until a scene meets
them, `wish_outcomes` measures what a scene has of each wish, `districts` composes what is too large
for the model, and `worst_scenes` keeps the scenes in which a pilot does worst.
"""
