"""The error that recordings raise."""

from lexstack.errors import LexstackError


class BagError(LexstackError):
    """A bag cannot be written or read, or is not one of lexstack's; the text names the file."""
