"""An encoder for worker processes, apart from the tests so that these load no PyTorch."""

from dataclasses import replace

from aeroscene.learning.writer.examples import UnencodableError


class OneKind:
    """Encoder that knows a scene by its number alone, and refuses some."""

    def __init__(self, example, refused=()):
        self.example, self.refused = example, refused

    def __call__(self, scene, _wish):
        if scene.seed in self.refused:
            raise UnencodableError("kind hovercraft is unknown")
        wish = replace(self.example.wish, n_areas=scene.seed)
        return replace(self.example, wish=wish)
