"""The errors that lexstack raises: one base class, and the place in the message."""


class LexstackError(Exception):
    """Base of every error that lexstack raises on purpose; its text is one clear line."""


class ConfigurationError(LexstackError):
    """A configuration file or value is wrong; the text names the file and the key."""


class NotANumberError(ConfigurationError):
    """A number was expected, and something else was there.

    Attributes:
        found: what was there.
    """

    def __init__(self, text: str, found: object) -> None:
        """Keep the value beside the text, for those who know its origin and can say more."""
        super().__init__(text)
        self.found = found


class ModelError(LexstackError):
    """A robot model cannot be built, or does not fit its configuration."""


class InputError(LexstackError):
    """A value from outside (message, argument) has a wrong length, type, name or is not finite."""
