"""What a scene is and where scenes come from."""


def __getattr__(name: str) -> str:
    """The version of the package, looked up only where it is asked for."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import version  # noqa: PLC0415

    return version("aeroscene")
