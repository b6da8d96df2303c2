"""Several hosts on one machine: network namespaces on a switch, made and removed by the test.

A host has a network and a /dev/shm of its own, so nothing but packets goes between hosts. Nothing
of the machine's own network is touched.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

_SHELL = 'mount -t tmpfs tmpfs /dev/shm && exec "$@"'


def why_not() -> str:
    """Return why namespaces cannot be made here, or '' if they can."""
    name = f"lx{os.getpid()}probe"
    try:
        _ip("netns", "add", name)
    except (OSError, subprocess.CalledProcessError) as error:
        return f"network namespaces are not permitted here: {getattr(error, 'stderr', error)}"
    try:
        subprocess.run(
            ["ip", "netns", "exec", name, "sh", "-c", _SHELL, "sh", "true"],
            check=True,
            capture_output=True,
            text=True,
        )
    except subprocess.CalledProcessError as error:
        return f"mounts in a namespace are not permitted here: {error.stderr}"
    finally:
        _ip("netns", "del", name)
    return ""


class Lan:
    """A switch, and hosts at it."""

    def __init__(self, addresses: Mapping[str, str]) -> None:
        """Make a host for every name, with its address in a /24 network."""
        self._mark = f"lx{os.getpid()}"
        self._hosts: dict[str, str] = {}
        self._ports: dict[str, str] = {}
        self._switch = f"{self._mark}switch"
        _ip("netns", "add", self._switch)
        try:
            self._in(self._switch, "link", "add", "br0", "type", "bridge", "mcast_snooping", "0")
            self._in(self._switch, "link", "set", "br0", "up")
            for number, (name, address) in enumerate(addresses.items()):
                self._add(number, name, address)
        except BaseException:
            self.close()
            raise

    def start(
        self, host: str, command: Sequence[str], log: Path, environment: Mapping[str, str]
    ) -> subprocess.Popen[bytes]:
        """Start a command on a host; its output goes to ``log``."""
        with log.open("wb") as file:
            return subprocess.Popen(
                ["ip", "netns", "exec", self._hosts[host], "sh", "-c", _SHELL, "sh", *command],
                stdout=file,
                stderr=subprocess.STDOUT,
                env=dict(environment),
                start_new_session=True,
            )

    def cut(self, host: str) -> None:
        """Take a host off the network."""
        self._in(self._switch, "link", "set", self._ports[host], "down")

    def heal(self, host: str) -> None:
        """Put it back."""
        self._in(self._switch, "link", "set", self._ports[host], "up")

    def close(self) -> None:
        """Remove everything; the processes must have ended."""
        for name in [*self._hosts.values(), self._switch]:
            subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)

    def _add(self, number: int, name: str, address: str) -> None:
        """Make one host and plug it in."""
        space = f"{self._mark}h{number}"
        _ip("netns", "add", space)
        self._hosts[name] = space
        port = f"port{number}"
        self._ports[name] = port
        self._in(
            self._switch,
            *("link", "add", port, "type", "veth", "peer", "name", "eth0", "netns", space),
        )
        self._in(self._switch, "link", "set", port, "master", "br0", "up")
        self._in(space, "address", "add", f"{address}/24", "dev", "eth0")
        for device in ("lo", "eth0"):
            self._in(space, "link", "set", device, "up")

    @staticmethod
    def _in(space: str, *arguments: str) -> None:
        """Run ``ip`` inside a namespace."""
        _ip("-n", space, *arguments)


def _ip(*arguments: str) -> None:
    """Run ``ip``."""
    subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True)
