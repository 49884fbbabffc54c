"""What a run cannot begin with."""


class BadInput(Exception):
    """A sentence: what cannot be, and what is allowed."""
