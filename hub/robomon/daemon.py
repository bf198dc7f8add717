"""The daemon: central and the robot's modules from start to orderly end."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import shutil
import signal
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from hub.errors import EndpointError, ModuleStartError
from hub.ipc.central import Central
from hub.ipc.keyring import Keyring, default_folder
from hub.robomon.policy import RestartPolicy
from hub.robomon.process import ModuleProcess
from hub.robomon.table import ModuleSpec, RobotTable, hub_arguments

_logger = logging.getLogger(__name__)

_STDIN = 0
_PERIOD_S = 0.02
_IN_ORDER_S = 0.25
"""Time in which modules are told to stop one after the other [s]."""
_FOLDER = "rune-hub-{pid}-"
_LONGEST_FOLDER = 60
"""Socket files have paths of about 100 bytes at most."""


@dataclass(slots=True)
class _Supervised:
    spec: ModuleSpec
    policy: RestartPolicy
    process: ModuleProcess | None = None
    start_at: float | None = 0.0


class Daemon:
    """Runs central and the modules until it is told to stop."""

    def __init__(self, table: RobotTable, *, as_json: bool) -> None:
        self._table = table
        self._as_json = as_json
        self._stop = threading.Event()
        self._gateway = ""
        self._modules = [
            _Supervised(spec, RestartPolicy(spec.restart_limit, spec.restart_window_s))
            for spec in table.modules
        ]

    def run(self, *, stop_with_stdin: bool) -> int:
        """Serve until SIGINT, SIGTERM, or the end of standard input if that is wanted.

        Returns:
            The exit code: 0, or 1 if a module had to be given up.

        Raises:
            EndpointError: The port is busy.
        """
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: self._stop.set())
        if stop_with_stdin:
            threading.Thread(target=self._wait_for_end_of_stdin, daemon=True).start()
        folder = _socket_folder()
        try:
            local = f"ipc://{folder}/central"
            robot = self._table.robot
            keyring = Keyring(Path(robot.keys) if robot.keys else default_folder())
            central = Central(
                [f"tcp://127.0.0.1:{robot.port}", local], gateway=robot.gateway, keyring=keyring
            )
            try:
                self._gateway = central.endpoints[-1] if robot.gateway else ""
                self._say("listening", endpoint=central.endpoints[0])
                self._serve(central, local)
            finally:
                self._end_modules()
                central.close()
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        return 1 if any(m.process is None and m.start_at is None for m in self._modules) else 0

    def _serve(self, central: Central, local: str) -> None:
        arguments = hub_arguments(local, self._table.robot.path)
        ready = False
        while not self._stop.is_set():
            now = time.monotonic()
            for module in self._modules:
                self._look_after(module, arguments, now)
            if not ready and set(central.connected()).issuperset(
                m.spec.name for m in self._modules
            ):
                ready = True
                self._say("ready", endpoint=central.endpoints[0])
            self._stop.wait(_PERIOD_S)
        _logger.info("stopping")

    def _look_after(self, module: _Supervised, arguments: list[str], now: float) -> None:
        """See whether a module ended, and start it when its time has come."""
        if module.process is not None and (code := module.process.exit_code()) is not None:
            module.process.end()
            module.process = None
            module.start_at = module.policy.ended(now)
            how = f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
            if module.start_at is None:
                _logger.error("%s %s; it ended too often and is given up", module.spec.name, how)
            else:
                _logger.warning("%s %s; it is started again", module.spec.name, how)
        if module.process is None and module.start_at is not None and now >= module.start_at:
            try:
                module.process = ModuleProcess(module.spec, arguments)
                _logger.info("%s started (pid %d)", module.spec.name, module.process.pid)
            except ModuleStartError as error:
                _logger.error("%s", error)
                module.start_at = module.policy.ended(now)

    def _end_modules(self) -> None:
        """Last started, first told: the driver is the last that can stop the wheels.

        Each gets a moment to end before the next is told, but one that hangs delays the others no
        longer than that: the robot must not drive on while somebody waits.
        """
        started = time.monotonic()
        running = [m.process for m in reversed(self._modules) if m.process is not None]
        for process in running:
            process.ask_to_stop()
            process.wait(started + _IN_ORDER_S - time.monotonic())
        for process in running:
            process.wait(started + process.spec.stop_timeout_s - time.monotonic())
            process.end()

    def _wait_for_end_of_stdin(self) -> None:
        with contextlib.suppress(OSError):  # it may be closed from the start
            while os.read(_STDIN, 4096):
                pass
        self._stop.set()

    def _say(self, event: str, endpoint: str) -> None:
        """Tell whoever started us, on standard output."""
        name = self._table.robot.name
        if self._as_json:
            pids = {m.spec.name: m.process.pid for m in self._modules if m.process}
            gateway = {"gateway": self._gateway} if self._gateway else {}
            facts = {"event": event, "robot": name, "hub": endpoint, "pids": pids}
            said = json.dumps(facts | gateway)
        elif event == "listening":
            way_in = f", for holders of keys at {self._gateway}" if self._gateway else ""
            said = f"{name}: hub at {endpoint}{way_in}, starting {len(self._modules)} modules"
        else:
            said = f"{name}: ready; Ctrl-C ends it"
        try:
            sys.stdout.write(said + "\n")
            sys.stdout.flush()
        except (OSError, ValueError, AttributeError) as error:
            # Whoever started us does not listen; the robot is served all the same.
            _logger.warning("cannot say %r on standard output: %s", event, error)


def _socket_folder() -> Path:
    """A new folder for socket files; those of daemons that were killed are removed."""
    candidates = (os.environ.get("XDG_RUNTIME_DIR", ""), tempfile.gettempdir())
    usable = [c for c in candidates if c and len(c) <= _LONGEST_FOLDER and Path(c).is_dir()]
    parent = Path(usable[0] if usable else "/tmp")
    for old in parent.glob(_FOLDER.format(pid="*") + "*"):
        pid = old.name.split("-")[2]
        if pid.isdigit() and not Path(f"/proc/{pid}").exists() and Path("/proc/self").exists():
            shutil.rmtree(old, ignore_errors=True)
    try:
        return Path(tempfile.mkdtemp(prefix=_FOLDER.format(pid=os.getpid()), dir=parent))
    except OSError as error:
        text = f"no folder for sockets can be made in {parent}: {error.strerror}"
        raise EndpointError(text) from error
