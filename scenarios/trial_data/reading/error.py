"""What may be wrong with a recording that is to be data."""


class TrialDataError(ValueError):
    """A recording lacks what is asked of it, or data cannot be written; one line says which."""
