"""Stacks that a user sends while a run goes on: one YAML text, checked as the files are."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import get_args

from lexstack.errors import ConfigurationError, ModelError
from lexstack.options import Name, Pattern, shown
from lexstack.robots import Team
from lexstack.tasks import Stack, StackConfig, build_stack
from lexstack_config.reader import advised, build, parse_yaml

LARGEST = 8192
"""Bytes of a text: reading that many takes the controller 60 ms, the largest file of ours 1 ms."""

MOST = 1000
"""So many stacks may be sent in one run."""

WHERE = "stack_yaml"
"""The field in which a text comes; it stands before every complaint, as a file's name would."""

_NAME: Pattern = get_args(Name)[1]


def read_stack(text: str, where: str = WHERE) -> StackConfig:
    """Return the stack in a text.

    Args:
        text: YAML in the schema of the stack files.
        where: names its origin in errors.

    Raises:
        ConfigurationError: it is too long, no plain YAML, or no stack; the text names the key.
    """
    size = len(text.encode("utf-8", "surrogatepass"))
    if size > LARGEST:
        raise ConfigurationError(f"{where}: {size} bytes, at most {LARGEST}")
    config = build(StackConfig, parse_yaml(text, where), where)
    # A file's name is its stack's; a text has none, and this one goes into topics and reports.
    _NAME.check(config.name, f"{where}: name")
    return config


def fit_stack(config: StackConfig, team: Team, where: str = WHERE) -> Stack:
    """Return a stack that was sent, built for a team; raises ConfigurationError."""
    absent = [name for name in config.named if name not in team.names]
    if absent:
        known = ", ".join(team.names)
        raise ConfigurationError(f"{where}: unknown robot {shown(absent[0])}; known: {known}")
    try:
        return build_stack(config, team, where)
    except (ConfigurationError, ModelError) as error:
        text = advised(error) if isinstance(error, ConfigurationError) else str(error)
        raise ConfigurationError(text) from error


class SentStacks:
    """The stacks that were sent in a run: one name stands for one stack.

    Attributes:
        texts: of the stacks that were accepted, by name.
    """

    def __init__(
        self, team: Team, configured: Mapping[str, StackConfig], unfit: Collection[str] = ()
    ) -> None:
        """Know the names of the scenario: its stacks, and those that do not fit its robots."""
        self.texts: dict[str, str] = {}
        self._team = team
        self._configured = configured
        self._unfit = unfit
        self._configs: dict[str, StackConfig] = {}

    def read(self, name: str, text: str) -> StackConfig:
        """Return the stack in a text that a request for ``name`` brings ('': the text's own).

        Raises:
            ConfigurationError: it is no stack, has another name than the request, or one that
                stands for another stack.
        """
        config = read_stack(text)
        if name and name != config.name:
            raise ConfigurationError(
                f"{WHERE}: name: {config.name!r}, but the request is for stack {shown(name)}"
            )
        known = self._configured.get(config.name) or self._configs.get(config.name)
        if config.name in self._unfit or known not in (None, config):
            raise ConfigurationError(
                f"{WHERE}: name: {config.name!r} is another stack already; give this one its own"
            )
        if known is None and len(self._configs) >= MOST:
            raise ConfigurationError(f"{WHERE}: {MOST} stacks were sent in this run already")
        return config

    def is_new(self, config: StackConfig) -> bool:
        """Return whether a stack is not known yet."""
        return config.name not in self._configured and config.name not in self._configs

    def fit(self, config: StackConfig) -> Stack:
        """Return a stack built for the robots; raises ConfigurationError."""
        return fit_stack(config, self._team)

    def keep(self, config: StackConfig, text: str) -> None:
        """Know a stack that was accepted from now on."""
        self._configs[config.name] = config
        self.texts[config.name] = text

    def forget(self) -> None:
        """Forget all that were sent: the plant begins from its start."""
        self._configs.clear()
        self.texts.clear()
