"""Invalid input of a run."""


class BadInput(Exception):
    """One sentence: the invalid value and what is allowed."""
