"""``scripts/bringup``: one host's share of a run on several hosts."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from lexstack.errors import ConfigurationError, LexstackError
from lexstack_bringup.commands.demo import (
    InterruptError,
    add_run_arguments,
    interrupt,
    is_file,
    play_shown,
    player_of,
    resolve_scenario,
    run_folder,
    tell_unfit,
)
from lexstack_bringup.hosts import SERVER, VARIABLES, HostsConfig, load_hosts
from lexstack_bringup.naming import Naming
from lexstack_bringup.player import PLAYER
from lexstack_bringup.processes import NODES, PLANNERS, bring_up, nodes_of
from lexstack_bringup.shared_memory import remove_abandoned
from lexstack_bringup.supervisor import Supervisor
from lexstack_config.own_folder import own_config, own_root
from lexstack_config.resolved import ResolvedScenario

_LOOK = 0.2  # s between two looks whether all still run
_KNOWN = (*NODES, *PLANNERS, PLAYER, SERVER)


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns 0, 1 where a node failed, 2 for bad arguments, 130 for Ctrl-C."""
    root, config = own_root(), own_config()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    try:
        options = _parser(config).parse_args(arguments)
        hosts = load_hosts(_host_file(config, options.host_config), _KNOWN)
        only = [name.strip() for name in options.only.split(",") if name.strip()]
        host = hosts.share(only)
        resolved = resolve_scenario(config, options)
        needed = hosts.needed((*nodes_of(resolved.scenario), PLAYER), resolved.scenario.name)
        share = Share(host, hosts, only, needed, Naming.of(options))
        out = run_folder(root, options.out, f"{resolved.scenario.name}-{share.host}")
    except ConfigurationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except InterruptError:
        return 130
    try:
        return share.run(resolved, out)
    except LexstackError as error:
        print(f"\nerror: {error}\nlogs: {out / 'logs'}", file=sys.stderr)
        return 1


class Share:
    """What one host runs."""

    def __init__(
        self,
        host: str,
        hosts: HostsConfig,
        only: Sequence[str],
        needed: Sequence[str],
        naming: Naming,
    ) -> None:
        """Take the nodes ``only`` of ``host``; those that are not ``needed`` stay away."""
        self.host = host
        self._hosts = hosts
        self._naming = naming
        self._only = [node for node in only if node in needed]
        self._away = [node for node in only if node not in needed]
        self._peers = [node for node in needed if node not in only and node != SERVER]

    def run(self, resolved: ResolvedScenario, out: Path) -> int:
        """Start the nodes, wait for their peers, play or wait, end all; returns the exit code."""
        (out / "scenario.yaml").write_text(resolved.to_yaml(), encoding="utf-8")
        variables = self._hosts.environment(self.host)
        for name in VARIABLES:
            os.environ.pop(name, None)
        os.environ.update(variables)
        here, others = ", ".join(self._only) or "nothing", ", ".join(self._peers) or "none"
        print(f"{self.host}: {here}; waits for {others}")
        tell_unfit(resolved)
        if self._away:
            print(f"  not needed by this scenario: {', '.join(self._away)}")
        print("".join(f"  {name}={value}\n" for name, value in variables.items()), flush=True)
        supervisor = Supervisor(out / "logs", variables)
        ready = False
        try:
            self._start_server(supervisor)
            if PLAYER in self._only:
                self._play(resolved, supervisor, out)
            else:
                self._bring_up(supervisor, out)
                ready = True
                self._stay(supervisor)
        except InterruptError:
            return 0 if ready else 130
        finally:
            _end(supervisor)
        return 0

    def _start_server(self, supervisor: Supervisor) -> None:
        """Start the discovery server, if this host has it."""
        if SERVER in self._only:
            address = self._hosts.hosts[self.host].address
            place = [address, str(self._hosts.server_port)]
            supervisor.start(SERVER, "lexstack_bringup.discovery_server", place)

    def _bring_up(self, supervisor: Supervisor, out: Path, users: Sequence[str] = ()) -> None:
        """Start the nodes, and say when they are connected with all others."""
        path, bag = out / "scenario.yaml", out / "bag"
        peers = [*self._peers, *users]
        wait, naming = self._hosts.wait, self._naming
        bring_up(supervisor, path, bag, peers, nodes=self._only, timeout=wait, naming=naming)
        print(f"{self.host}: all nodes are connected", flush=True)

    def _play(self, resolved: ResolvedScenario, supervisor: Supervisor, out: Path) -> None:
        """Bring up, and play the scenario from this process."""
        with player_of(resolved, self._naming) as player:
            self._bring_up(supervisor, out, users=[PLAYER])
            play_shown(resolved, player, supervisor)
            print(f"{self.host}: the scenario has been played", flush=True)

    def _stay(self, supervisor: Supervisor) -> None:
        """Watch the nodes until a signal comes; raises ChildDiedError when one ends."""
        while True:
            supervisor.check()
            time.sleep(_LOOK)


def _end(supervisor: Supervisor) -> None:
    """End all nodes in order; a second signal changes nothing."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    killed = supervisor.end()
    if killed:
        print(f"warning: had to be killed: {', '.join(killed)}", file=sys.stderr)
    remove_abandoned()


def _parser(config: Path) -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="./scripts/bringup",
        description="Start one host's share of the nodes of a run, wait until they are connected "
        "with those of the other hosts, and end them at Ctrl-C or with the scenario.",
    )
    parser.add_argument(
        "--only", required=True, metavar="NODES", help=f"comma-separated: {', '.join(_KNOWN)}"
    )
    parser.add_argument(
        "--host-config",
        required=True,
        metavar="FILE",
        help="which node runs where: a file, or the name of one in config/hosts",
    )
    add_run_arguments(parser, config)
    return parser


def _host_file(config: Path, given: str) -> Path:
    """Return a configured file by its name, or any file."""
    configured = config / "hosts" / f"{given}.yaml"
    return configured if is_file(configured) else Path(given)


if __name__ == "__main__":
    sys.exit(main())
