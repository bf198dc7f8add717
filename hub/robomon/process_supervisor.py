"""Carries out what the policy decides: starts, ends and looks at the modules' processes."""

from __future__ import annotations

import logging
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hub.errors import ModuleStartError
from hub.gcm.common import COMMON_COMMAND, CommonCommand, CommonCommandKind
from hub.gcm.supervision import ModulePhase
from hub.ipc.client import Client
from hub.robomon.capability_probe import CapabilityProbe
from hub.robomon.module_lifecycle import ModuleLifecycle, ProcessAction
from hub.robomon.module_logs import ModuleLogs
from hub.robomon.policy import ModulePolicy
from hub.robomon.process import ModuleProcess, OrphanReaper, Usage, end_strays
from hub.robomon.warm_parent import WarmParent

_logger = logging.getLogger(__name__)

BY_ROBOMON = "by robomon"
"""Argument of the common commands that the daemon sends itself."""
_PERIOD_S = 0.05
_SAMPLE_S = 1.0
_SETTLED_S = 10.0
"""Time after which modules that do not run are asked what they can do, at the latest [s]."""
_IN_ORDER_S = 0.25
"""Time in which modules are told to stop one after the other [s]."""


@dataclass(slots=True)
class _Running:
    """A process, and what it had taken when it was looked at last."""

    process: ModuleProcess
    watched: int | None
    usage: Usage | None = None
    looked: float = 0.0
    processor: float = math.nan


class ProcessSupervisor:
    """The modules' processes.

    Attributes:
        supervisor: Decides.
    """

    def __init__(
        self,
        supervisor: ModulePolicy,
        client: Client,
        outputs: ModuleLogs,
        *,
        arguments: Sequence[str],
        description_arguments: Sequence[str],
        parent: WarmParent | None,
        changed: Callable[[], None],
    ) -> None:
        """Begin; nothing is started before the client is served.

        Args:
            supervisor: Decides.
            client: The daemon's connection; its loop calls us.
            outputs: Gets what modules write.
            arguments: What is added to each module's command.
            description_arguments: What is added instead to ask what it can do.
            parent: Forks Python modules; None: all are spawned.
            changed: Called when something of interest has changed.
        """
        self.supervisor = supervisor
        self._client = client
        self._outputs = outputs
        self._arguments = arguments
        self._parent = parent
        self._changed = changed
        self._clock = time.monotonic
        self._guardian = OrphanReaper()
        self._inquiry = CapabilityProbe(description_arguments, parent)
        self._running: dict[str, _Running] = {}
        self._said: dict[str, tuple[ModulePhase, str, int]] = {}
        self._began = self._clock()
        client.every(_PERIOD_S, self.look)
        client.every(_SAMPLE_S, self._sample)

    @property
    def pids(self) -> dict[str, int]:
        """Process ids of the modules that run."""
        return {name: running.process.pid for name, running in self._running.items()}

    def processor(self, name: str) -> float:
        """The part of one processor that a module takes; NaN when not known."""
        running = self._running.get(name)
        return running.processor if running else math.nan

    def memory_mb(self, name: str) -> float:
        """Resident memory of a module [MB]; NaN when not known."""
        running = self._running.get(name)
        return running.usage.memory_mb if running and running.usage else math.nan

    def look(self) -> None:
        """See what happened, and do what is to be done now."""
        for name, running in list(self._running.items()):
            code = running.process.exit_code()
            if code is not None:
                self._bury(name, code)
        for life, action in self.supervisor.step(self._clock()):
            self._do(life, action)
        self._inquire()
        self._tell_changes()

    def close(self) -> None:
        """End all. Last started, first told: the driver is the last that can stop the wheels.

        Each gets a moment to end before the next is told, but one that hangs delays the others no
        longer than that: the robot must not drive on while somebody waits.
        """
        self._inquiry.close()
        started = self._clock()
        running = [each.process for each in reversed(self._running.values())]
        for process in running:
            _logger.info("%s is told to stop", process.spec.name)
            process.ask_to_stop()
            process.wait(started + _IN_ORDER_S - self._clock())
        for process in running:
            process.wait(started + process.spec.stop_timeout_s - self._clock())
            process.end()
        if self._parent is not None:
            self._parent.close()
        end_strays({self._guardian.pid})
        self._guardian.close()

    def _do(self, life: ModuleLifecycle, action: ProcessAction) -> None:
        name = life.spec.name
        if action is ProcessAction.START:
            self._start(life)
            return
        running = self._running.get(name)
        if running is None:
            return
        if action is ProcessAction.COMMAND:
            self._client.publish(
                COMMON_COMMAND,
                CommonCommand(module=name, command=CommonCommandKind.STOP, argument=BY_ROBOMON),
            )
        elif action is ProcessAction.TERMINATE:
            running.process.ask_to_stop()
        else:
            running.process.kill()

    def _start(self, life: ModuleLifecycle) -> None:
        name, now = life.spec.name, self._clock()
        try:
            process = ModuleProcess(life.spec, self._arguments, self._parent)
        except ModuleStartError as error:
            life.not_started(str(error), now)
            _log_end(life)
            return
        self._running[name] = _Running(process=process, watched=self._watch(process.pid))
        life.started(process.pid, now)
        self._guardian.watch(process.pid)
        self._outputs.add(name, process.output)
        _logger.info("%s started (pid %d)", name, process.pid)

    def _watch(self, pid: int) -> int | None:
        """Have the loop look at once when this process ends, where the system can tell."""
        try:
            file = os.pidfd_open(pid)
        except (OSError, AttributeError):
            return None
        self._client.loop.watch(file, self.look)
        return file

    def _bury(self, name: str, code: int) -> None:
        running = self._running.pop(name)
        if running.watched is not None:
            self._client.loop.unwatch(running.watched)
            os.close(running.watched)
        running.process.end()
        self._guardian.forget(running.process.pid)
        how = f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        life = self.supervisor.lives[name]
        life.ended(how, self._clock())
        _log_end(life)

    def _inquire(self) -> None:
        """Ask modules what they can do, once none of those that are to run always is starting."""
        lives = self.supervisor.lives.values()
        settled = not any(life.phase is ModulePhase.STARTING for life in lives if life.spec.always)
        if settled or self._clock() - self._began > _SETTLED_S:
            self._inquiry.ask(self.supervisor.unasked())
        self._inquiry.look(self._clock())

    def _sample(self) -> None:
        """See what the modules take, and end what is left of ended ones."""
        now = self._clock()
        self._guardian.look()
        if self._parent is not None:
            self._parent.look()
        for name, running in self._running.items():
            usage = running.process.usage()
            if usage is None:
                continue
            if running.usage is not None and now > running.looked:
                spent = usage.processor_s - running.usage.processor_s
                running.processor = spent / (now - running.looked)
            running.usage, running.looked = usage, now
            self.supervisor.used(name, usage.memory_mb, now)
        own = {self._guardian.pid, self._inquiry.pid, self._parent.pid if self._parent else 0}
        strays = end_strays({*own, *self.pids.values()})
        if strays:
            _logger.warning("%d processes that modules had left behind were killed", strays)

    def _tell_changes(self) -> None:
        lives = self.supervisor.lives
        now = {name: (life.phase, life.why, life.starts) for name, life in lives.items()}
        if now == self._said:
            return
        for name, (phase, why, _) in now.items():
            if phase is ModulePhase.STOPPING and now[name] != self._said.get(name):
                _logger.info("%s %s; it is told to stop", name, why)
        self._said = now
        self._changed()


def _log_end(life: ModuleLifecycle) -> None:
    if life.phase is ModulePhase.FAILED:
        _logger.error("%s %s", life.spec.name, life.why)
    elif life.phase is ModulePhase.WAITING:
        _logger.warning("%s %s", life.spec.name, life.why)
    else:
        _logger.info("%s ended", life.spec.name)
