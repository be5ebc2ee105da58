"""Error for recordings that cannot be used as data."""


class TrialDataError(ValueError):
    """A recording lacks required data, or data cannot be written; one line says which."""
