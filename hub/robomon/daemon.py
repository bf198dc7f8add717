"""The daemon: runs central and the robot's modules."""

from __future__ import annotations

import contextlib
import gc
import json
import logging
import os
import secrets
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path

from hub.command_line import ending_signals
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.supervision import ModulePhase
from hub.hub_sockets import HubFolder
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.security.keyring import Keyring, default_folder
from hub.ipc.security.publish_rights import ROBOMON
from hub.nonblocking_logging import start_logging
from hub.robomon.control_service import ControlService
from hub.robomon.mission_want import MissionWant
from hub.robomon.module_logs import LogFolder, ModuleLogs
from hub.robomon.module_table import (
    RobotTable,
    common_imports,
    hub_arguments,
    robot_arguments,
)
from hub.robomon.policy import ModulePolicy
from hub.robomon.process import adopt_orphans
from hub.robomon.process_supervisor import ProcessSupervisor
from hub.robomon.recording_want import RecordingWant
from hub.robomon.reporting import Reporting
from hub.robomon.sd_notify import Notifier
from hub.robomon.warm_parent import WarmParent
from hub.robots.registry import body_of

_logger = logging.getLogger(__name__)

_STDIN = 0
_CONNECT_S = 10.0
_LISTEN_S = 0.5
_FOLDER_S = 1.0
"""Time between two looks at the folder of sockets [s]."""
_PROOFS = {"tcp": "its token", "gateway": "keys"}
_ABSTRACT = sys.platform == "linux"


def run(table: RobotTable, *, name: str, spawn: bool, as_json: bool, stop_with_stdin: bool) -> int:
    """Run a robot's hub in this process, which has one thread and no socket yet.

    Args:
        table: The robot and its modules.
        name: The hub's name on this machine; empty: the robot's.
        spawn: Start each module as a new program; do not fork it.
        as_json: Report events as JSON lines.
        stop_with_stdin: Stop at the end of standard input.

    Returns:
        The exit code: 0; 1: a module was given up.

    Raises:
        EndpointError: A hub of this name runs, or a port is busy.
        SystemExit: In a forked module, at its end.
    """
    parent = None
    if adopt_orphans() and not spawn:
        parent = WarmParent(common_imports(table))
        parent.fork_from_here()
    start_logging("hub", logging.INFO)
    gc.freeze()  # neither a collection nor the end of the process visits the imported objects
    daemon = Daemon(table, parent, name=name, as_json=as_json)
    return daemon.run(stop_with_stdin=stop_with_stdin)


class Daemon:
    """Runs central and the modules until a signal stops it."""

    def __init__(
        self, table: RobotTable, parent: WarmParent | None, *, name: str, as_json: bool
    ) -> None:
        """Take the modules of this table.

        Args:
            table: The robot and its modules.
            parent: Forks Python modules; None: all are spawned.
            name: The hub's name on this machine; empty: the robot's.
            as_json: Report events as JSON lines.
        """
        self._table = table
        self._name = name or table.robot.name
        self._parent = parent
        self._as_json = as_json
        # No Event: a second signal during its `set` would wait for the first without end.
        self._stopping = False
        self._ways_in: dict[str, str] = {}
        self._wake: Callable[[], None] = lambda: None
        self._notifier = Notifier.from_environment(os.environ, os.getpid())
        self._policy = ModulePolicy(table.modules)

    def run(self, *, stop_with_stdin: bool) -> int:
        """Serve until SIGINT, SIGTERM, or, by request, the end of standard input.

        Returns:
            The exit code: 0; 1: a module was given up.

        Raises:
            EndpointError: A hub of this name runs, or a port is busy.
            KeyFileError: The keys of the gateway, or the token of the port, cannot be used.
        """
        for number in ending_signals():
            signal.signal(number, lambda *_: self._end())
        if stop_with_stdin:
            threading.Thread(target=self._wait_for_end_of_stdin, daemon=True).start()
        robot = self._table.robot
        with contextlib.ExitStack() as stack:
            folder = stack.enter_context(contextlib.closing(HubFolder(self._name)))
            # A module that restarts finds its central even where the folder was removed.
            local = (
                f"ipc://@rune-hub-{os.getpid()}-{secrets.token_hex(4)}"
                if _ABSTRACT
                else folder.endpoint
            )
            tcp = [f"tcp://{robot.listen}"] if robot.listen else []
            keyring = Keyring(Path(robot.keys) if robot.keys else default_folder())
            central = Central(
                list(dict.fromkeys([folder.endpoint, local, *tcp])),
                gateways=[curve_gateway(robot.gateway, keyring)] if robot.gateway else [],
                reserved=frozenset(spec.name for spec in self._table.modules),
            )
            stack.callback(central.close)
            if robot.listen:
                own = next(each for each in central.endpoints if each.startswith("tcp://"))
                self._ways_in["tcp"] = own
                folder.publish_tcp(own)
            if robot.gateway:
                self._ways_in["gateway"] = central.endpoints[-1]
            logs = stack.enter_context(contextlib.closing(LogFolder(robot.logs, robot.name)))
            outputs = stack.enter_context(contextlib.closing(ModuleLogs(logs.path)))
            endpoint = folder.endpoint
            self._report("listening", endpoint, {})
            client = stack.enter_context(contextlib.closing(Client(ROBOMON, local)))
            desk = ControlService(client, central.peer_of)
            MissionWant(client, self._policy.wants, robot, controlled=lambda: desk.owned)
            RecordingWant(client, self._policy.wants, robot)
            client.every(_FOLDER_S, lambda: _keep(folder, central))
            self._serve(client, outputs, local, endpoint)
        lifecycles = self._policy.lifecycles.values()
        return 1 if any(lifecycle.phase is ModulePhase.FAILED for lifecycle in lifecycles) else 0

    def _serve(self, client: Client, outputs: ModuleLogs, local: str, endpoint: str) -> None:
        self._wake = lambda: client.post(lambda: None)
        client.when_slept(lambda time: _logger.warning("this computer slept for %.1f s", time))
        client.wait_connected(_CONNECT_S)
        if self._notifier.period is not None:
            client.every(self._notifier.period, self._notifier.alive)
        self._notifier.ready(f"{self._table.robot.name}: starting modules")
        robot = self._table.robot
        processes = ProcessSupervisor(
            self._policy,
            client,
            outputs,
            arguments=hub_arguments(local, robot),
            description_arguments=robot_arguments(robot),
            parent=self._parent,
            changed=lambda: self._changed(reporting),
        )
        reporting = Reporting(client, processes, outputs, body_of(self._table.robot))
        ready = False
        try:
            processes.step()
            while not self._stopping:
                self._listen(client)
                if not ready and self._all_run():
                    ready = True
                    self._report("ready", endpoint, processes.pids)
            _logger.info("stopping")
            self._notifier.stopping()
        finally:
            processes.close()

    def _changed(self, reporting: Reporting) -> None:
        """Report the modules' state on the bus and to systemd."""
        reporting.publish()
        lifecycles = self._policy.lifecycles.values()
        words = (
            f"{lifecycle.spec.name} {lifecycle.phase.name.lower()}" for lifecycle in lifecycles
        )
        self._notifier.status(", ".join(words))

    @staticmethod
    def _listen(client: Client) -> None:
        try:
            client.listen(_LISTEN_S)
        except Exception:  # a fault of the daemon must not stop the robot's modules
            _logger.exception("the daemon goes on after a fault")

    def _all_run(self) -> bool:
        lifecycles = self._policy.lifecycles.values()
        return all(
            lifecycle.phase is ModulePhase.RUNNING
            for lifecycle in lifecycles
            if lifecycle.spec.always
        )

    def _end(self) -> None:
        self._stopping = True
        self._wake()

    def _wait_for_end_of_stdin(self) -> None:
        with contextlib.suppress(OSError):  # it may be closed at the start
            while os.read(_STDIN, 4096):
                pass
        self._end()

    def _report(self, event: str, endpoint: str, pids: Mapping[str, int]) -> None:
        """Report to the process that started the daemon, on standard output."""
        name = self._table.robot.name
        if self._as_json:
            facts = {"event": event, "robot": name, "hub": endpoint, "pids": dict(pids)}
            text = json.dumps(facts | self._ways_in)
        elif event == "listening":
            count = sum(spec.always for spec in self._table.modules)
            ways = "".join(
                f", for holders of {_PROOFS[kind]} at {place}"
                for kind, place in self._ways_in.items()
            )
            text = f"{name}: hub {self._name} of this machine{ways}, starting {count} modules"
        else:
            text = f"{name}: ready; Ctrl-C ends it"
        try:
            sys.stdout.write(text + "\n")
            sys.stdout.flush()
        except (OSError, ValueError, AttributeError) as error:
            # The report has no reader; the hub still runs.
            _logger.warning("cannot say %r on standard output: %s", event, error)


def _keep(folder: HubFolder, central: Central) -> None:
    """Listen again where the socket files were removed."""
    if folder.lost() and folder.make_again():
        central.listen_again(folder.endpoint)
        _logger.warning("the sockets in %s were removed; the hub listens there again", folder.path)
