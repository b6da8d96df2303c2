"""What a fuzzer does to configuration: any bytes as any file; a refusal is one clear line."""

from __future__ import annotations

from lexstack.errors import ConfigurationError
from lexstack.mpc import HtmpcConfig
from lexstack.robots import RobotFile
from lexstack.tasks import StackConfig
from lexstack_bringup.hosts import HostsConfig
from lexstack_config.reader import build, parse_yaml
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import ScenarioConfig
from support.scenario import CONFIG, resolved

KINDS = {
    "robots": RobotFile,
    "stacks": StackConfig,
    "scenarios": ScenarioConfig,
    "htmpc": HtmpcConfig,
    "hosts": HostsConfig,
    "resolved": ResolvedScenario,
}
LONGEST = 2000  # characters of a refusal


def seeds() -> list[bytes]:
    """Return every configuration file, with the number of its kind in front."""
    files = [
        bytes([number]) + path.read_bytes()
        for number, folder in enumerate(KINDS)
        for path in sorted((CONFIG / folder).glob("*.yaml"))
    ]
    return [*files, bytes([len(KINDS) - 1]) + resolved().to_yaml().encode()]


def one(data: bytes) -> bool:
    """Read one input; returns whether it was taken; raises AssertionError for a bad refusal."""
    if not data:
        return False
    kind = list(KINDS.values())[data[0] % len(KINDS)]
    try:
        text = data[1:].decode("utf-8")
    except UnicodeDecodeError:
        return False  # read_text refuses it, which a test of its own shows
    try:
        build(kind, parse_yaml(text, "file.yaml"), "file.yaml")
    except ConfigurationError as error:
        check_line(str(error))
        return False
    return True


def check_line(line: str) -> None:
    """Raise AssertionError unless a refusal is one printable line that begins with its place."""
    assert line.startswith("file.yaml: "), line[:200]
    check_short(line)


def check_short(line: str) -> None:
    """Raise AssertionError unless a refusal is one printable line that can be read."""
    assert line.isprintable(), line[:200]
    assert len(line) <= LONGEST, f"{len(line)} characters: {line[:200]}"
