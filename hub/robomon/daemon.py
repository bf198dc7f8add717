"""The daemon: runs central and the robot's modules."""

from __future__ import annotations

import contextlib
import gc
import json
import logging
import os
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from hub import paths
from hub.errors import EndpointError
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.supervision import ModulePhase
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
_FOLDER = "rune-hub-{pid}-"


def run(table: RobotTable, *, spawn: bool, as_json: bool, stop_with_stdin: bool) -> int:
    """Run a robot's hub in this process, which has one thread and no socket yet.

    Args:
        table: The robot and its modules.
        spawn: Start each module as a new program; do not fork it.
        as_json: Report events as JSON lines.
        stop_with_stdin: Stop at the end of standard input.

    Returns:
        The exit code: 0; 1: a module was given up.

    Raises:
        EndpointError: The port is busy.
        SystemExit: In a forked module, at its end.
    """
    parent = None
    if adopt_orphans() and not spawn:
        parent = WarmParent(common_imports(table))
        parent.fork_from_here()
    start_logging("hub", logging.INFO)
    gc.freeze()  # neither a collection nor the end of the process visits the imported objects
    return Daemon(table, parent, as_json=as_json).run(stop_with_stdin=stop_with_stdin)


class Daemon:
    """Runs central and the modules until a signal stops it."""

    def __init__(self, table: RobotTable, parent: WarmParent | None, *, as_json: bool) -> None:
        """Take the modules of this table.

        Args:
            table: The robot and its modules.
            parent: Forks Python modules; None: all are spawned.
            as_json: Report events as JSON lines.
        """
        self._table = table
        self._parent = parent
        self._as_json = as_json
        # No Event: a second signal during its `set` would wait for the first without end.
        self._stopping = False
        self._gateway = ""
        self._wake: Callable[[], None] = lambda: None
        self._notifier = Notifier.from_environment(os.environ, os.getpid())
        self._policy = ModulePolicy(table.modules)

    def run(self, *, stop_with_stdin: bool) -> int:
        """Serve until SIGINT, SIGTERM, or, by request, the end of standard input.

        Returns:
            The exit code: 0; 1: a module was given up.

        Raises:
            EndpointError: The port is busy.
        """
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: self._end())
        if stop_with_stdin:
            threading.Thread(target=self._wait_for_end_of_stdin, daemon=True).start()
        robot = self._table.robot
        with contextlib.ExitStack() as stack:
            folder = stack.enter_context(_socket_folder())
            local = f"ipc://{folder}/central"
            keyring = Keyring(Path(robot.keys) if robot.keys else default_folder())
            central = Central(
                [f"tcp://127.0.0.1:{robot.port}", local],
                gateways=[curve_gateway(robot.gateway, keyring)] if robot.gateway else [],
                reserved=frozenset(spec.name for spec in self._table.modules),
            )
            stack.callback(central.close)
            self._gateway = central.endpoints[-1] if robot.gateway else ""
            logs = stack.enter_context(contextlib.closing(LogFolder(robot.logs, robot.name)))
            outputs = stack.enter_context(contextlib.closing(ModuleLogs(logs.path)))
            self._report("listening", central.endpoints[0], {})
            client = stack.enter_context(contextlib.closing(Client(ROBOMON, local)))
            desk = ControlService(client, central.peer_of)
            MissionWant(client, self._policy.wants, robot, controlled=lambda: desk.owned)
            RecordingWant(client, self._policy.wants, robot)
            self._serve(client, outputs, local, central.endpoints[0])
        lifecycles = self._policy.lifecycles.values()
        return 1 if any(lifecycle.phase is ModulePhase.FAILED for lifecycle in lifecycles) else 0

    def _serve(self, client: Client, outputs: ModuleLogs, local: str, endpoint: str) -> None:
        self._wake = lambda: client.post(lambda: None)
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
            gateway = {"gateway": self._gateway} if self._gateway else {}
            facts = {"event": event, "robot": name, "hub": endpoint, "pids": dict(pids)}
            text = json.dumps(facts | gateway)
        elif event == "listening":
            count = sum(spec.always for spec in self._table.modules)
            way_in = f", for holders of keys at {self._gateway}" if self._gateway else ""
            text = f"{name}: hub at {endpoint}{way_in}, starting {count} modules"
        else:
            text = f"{name}: ready; Ctrl-C ends it"
        try:
            sys.stdout.write(text + "\n")
            sys.stdout.flush()
        except (OSError, ValueError, AttributeError) as error:
            # The report has no reader; the hub still runs.
            _logger.warning("cannot say %r on standard output: %s", event, error)


@contextlib.contextmanager
def _socket_folder() -> Iterator[Path]:
    """A new folder for socket files; those of daemons that were killed are removed."""
    parent = paths.for_sockets()
    for old in parent.glob(_FOLDER.format(pid="*") + "*"):
        pid = old.name.split("-")[2]
        if pid.isdigit() and not Path(f"/proc/{pid}").exists() and Path("/proc/self").exists():
            shutil.rmtree(old, ignore_errors=True)
    try:
        made = Path(tempfile.mkdtemp(prefix=_FOLDER.format(pid=os.getpid()), dir=parent))
    except OSError as error:
        text = f"no folder for sockets can be made in {parent}: {error.strerror}"
        raise EndpointError(text) from error
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)
