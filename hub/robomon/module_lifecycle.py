"""The life of one module: what happened to it and the time, to what is to be done; pure."""

from __future__ import annotations

import enum
import math
from collections import deque

from hub.gcm.supervision import ModulePhase, keep_alive_s
from hub.robomon.module_table import ModuleSpec

_REMEMBERED = 8
"""Process ids of earlier starts whose last words may still come."""
_TERM_S = 0.5
"""Time that SIGTERM leaves to a module that hangs [s]; it would not hear the command."""


class ProcessAction(enum.Enum):
    """What is to be done with a module's process."""

    START = "start"
    COMMAND = "tell it to stop"
    TERMINATE = "send it SIGTERM"
    KILL = "send it SIGKILL"


_UNWANTED = "is wanted by nobody"
_ESCALATION = (ProcessAction.COMMAND, ProcessAction.TERMINATE, ProcessAction.KILL)


class ModuleLifecycle:
    """One module from its first start to its last end; every method gets the time [s].

    Attributes:
        spec: What the robot file says.
        phase: What is done with it.
        why: Why it is in this phase, for people, after its name: "was stopped by somebody"; empty
            where it runs and always did since somebody had it started.
        pid: Process id; 0 while it has no process.
        since: When it was started last, or was to be.
        starts: How often it was started.
        provides: Its capabilities, as far as known.
        needs: What it needs of others, as far as known.
        asked: Whether it said so itself.
        held: Whether somebody stopped it: it is not started until somebody starts it.
        pinned: Whether somebody started it: it runs though nobody wants its capabilities.
        replaced_by: The module that does its work, as it could not; empty if none does.
    """

    def __init__(self, spec: ModuleSpec) -> None:
        self.spec = spec
        self.phase = ModulePhase.STOPPED
        self.why = "was not started yet"
        self.pid = 0
        self.since = 0.0
        self.starts = 0
        self.provides = frozenset(spec.capabilities)
        self.needs = frozenset(spec.needs)
        self.asked = False
        self.held = False
        self.pinned = False
        self.replaced_by = ""
        self._ends: deque[float] = deque()
        self._failure = ""
        self._early = 0
        self._earlier: deque[int] = deque(maxlen=_REMEMBERED)
        self._heard = 0.0
        self._heard_itself = False
        self._start_at = 0.0
        self._stopping_since = 0.0
        self._done = 0
        self._hanging = False
        self._deliberate = True
        self._wanted_until = -math.inf

    @property
    def up(self) -> bool:
        """Whether it has a process that is meant to go on."""
        return self.phase in (ModulePhase.STARTING, ModulePhase.RUNNING)

    @property
    def has_process(self) -> bool:
        """Whether it has a process."""
        return self.up or self.phase is ModulePhase.STOPPING

    @property
    def keep_alive_s(self) -> float:
        """Silence after which it counts as hanging [s]; 0: it does not announce itself."""
        given = self.spec.keep_alive_s
        return keep_alive_s(self.provides) if given is None else given

    @property
    def usable(self) -> bool:
        """Whether it runs or can be started."""
        return not self.held and self.phase is not ModulePhase.FAILED

    @property
    def troubled(self) -> bool:
        """Whether it ended soon after its start, and not for the first time."""
        return self.phase is ModulePhase.WAITING and self._early > 1

    @property
    def sound(self) -> bool:
        """Whether it runs, or can be started at once."""
        return self.usable and not self.troubled

    def learned(self, provides: frozenset[str], needs: frozenset[str]) -> None:
        """It said itself what it can do."""
        self.provides, self.needs, self.asked = provides, needs, True

    def started(self, pid: int, now: float) -> None:
        """Its process was started."""
        self.pid, self.since, self._heard = pid, now, now
        self._heard_itself = False
        self.starts += 1
        if self.keep_alive_s > 0.0:
            self._enter(ModulePhase.STARTING, "was started")
        else:
            self._run()

    def not_started(self, why: str, now: float) -> None:
        """The system could not start it."""
        self.since = now
        self._fail(why, now)

    def announced(self, pid: int, now: float) -> bool:
        """It says that it lives; False if that is from a process before this one, or another.

        Where the process itself was never heard, it may have started the one that speaks.
        """
        if not self.has_process:
            return False
        if pid == self.pid:
            self._heard_itself = True
        elif self._heard_itself or pid in self._earlier:
            return False
        self._heard = now
        if self.phase is ModulePhase.STARTING:
            self._run()
        return True

    def stand_back(self, other: str) -> None:
        """Another does its work until that one cannot."""
        self.replaced_by = other
        phase = ModulePhase.STOPPED if self.phase is ModulePhase.WAITING else self.phase
        self._enter(phase, f"{self.why.partition(';')[0]}; {other} does its work")

    def forgive(self, now: float) -> None:
        """We were away ourselves: nothing is known of the time since."""
        self._heard = max(self._heard, now)

    def over_limit(self, what: str, now: float) -> None:
        """It takes more than it may."""
        if self.phase is ModulePhase.RUNNING:
            self._stop(what, now, deliberate=False)

    def told_to_stop(self, now: float) -> None:
        """Somebody stops it; it is not started again by itself."""
        self.held, self.pinned, self.replaced_by = True, False, ""
        if self.up:
            self._stop("was stopped by somebody", now, deliberate=True)
        elif self.phase is ModulePhase.STOPPING:
            self._deliberate = True
        else:
            self._enter(ModulePhase.STOPPED, "was stopped by somebody")

    def told_to_start(self) -> None:
        """Somebody starts it; earlier failures are forgotten."""
        self.replaced_by = ""
        self.held, self.pinned = False, not self.spec.always
        self._ends.clear()
        self._failure, self._early = "", 0
        self._start_at = -math.inf
        if not self.has_process:
            self._enter(ModulePhase.STOPPED, "is started by somebody")

    def told_to_restart(self, now: float) -> None:
        """Somebody has it end and begin anew."""
        self.told_to_start()
        if self.up:
            self._stop("is started anew by somebody", now, deliberate=True)

    def ended(self, how: str, now: float) -> None:
        """Its process is gone."""
        self._earlier.append(self.pid)
        self.pid = 0
        if self.phase is not ModulePhase.STOPPING:
            self._fail(how, now)
        elif self._deliberate:
            self._enter(ModulePhase.STOPPED, self.why)
        else:
            self._fail(self.why, now)

    def step(self, now: float, *, wanted: bool, ready: bool) -> ProcessAction | None:
        """What is to be done now.

        Args:
            now: The time [s].
            wanted: Whether it is to run.
            ready: Whether what it needs of others is there.
        """
        if wanted:
            self._wanted_until = now + self.spec.linger_s
        if self.phase is ModulePhase.STOPPING:
            return self._escalate(now)
        if not wanted and now > self._wanted_until:
            return self._unwanted(now)
        idle = self.phase in (ModulePhase.STOPPED, ModulePhase.WAITING)
        if idle and wanted and not self.held and ready and now >= self._start_at:
            return ProcessAction.START
        return None

    def _unwanted(self, now: float) -> ProcessAction | None:
        if self.up:
            self._stop(_UNWANTED, now, deliberate=True)
            return self._escalate(now)
        if self.phase is ModulePhase.WAITING:
            self._enter(ModulePhase.STOPPED, _UNWANTED)
        return None

    def look(self, now: float) -> None:
        """See whether it has been silent for too long."""
        longest = self.keep_alive_s
        if longest <= 0.0:
            return
        if self.phase is ModulePhase.STARTING and now - self._heard > self.spec.start_timeout_s:
            self._hang(f"did not announce itself in {self.spec.start_timeout_s:g} s", now)
        elif self.phase is ModulePhase.RUNNING and now - self._heard > longest:
            self._hang(f"hung: silent for {longest:g} s", now)

    def _run(self) -> None:
        self._enter(ModulePhase.RUNNING, self._failure and f"runs again; it {self._failure}")

    def _hang(self, why: str, now: float) -> None:
        self._stop(why, now, deliberate=False)
        self._done, self._hanging = 1, True

    def _stop(self, why: str, now: float, *, deliberate: bool) -> None:
        self._deliberate, self._hanging = deliberate, False
        self._stopping_since, self._done = now, 0
        self._enter(ModulePhase.STOPPING, why)

    def _escalate(self, now: float) -> ProcessAction | None:
        """The next step of ending it, when its time has come; each is taken once."""
        if self._done >= len(_ESCALATION):
            return None
        spec = self.spec
        after = (0.0, spec.ask_timeout_s, spec.stop_timeout_s)
        if self._hanging:
            after = (0.0, 0.0, min(_TERM_S, spec.stop_timeout_s))
        if now - self._stopping_since < after[self._done]:
            return None
        self._done += 1
        return _ESCALATION[self._done - 1]

    def _fail(self, why: str, now: float) -> None:
        """It ended by itself: when it may start again, or never."""
        spec = self.spec
        while self._ends and self._ends[0] <= now - spec.restart_window_s:
            self._ends.popleft()
        if len(self._ends) >= spec.restart_limit:
            self._enter(ModulePhase.FAILED, f"{why}; that was too often, so it is given up")
            return
        settled = now - self.since >= spec.settled_s
        self._failure = why
        self._early = 1 if settled else self._early + 1
        pause = spec.backoff_s * 2.0 ** (self._early - 2) if self._early > 1 else 0.0
        self._ends.append(now)
        self._start_at = now + min(pause, spec.backoff_longest_s)
        self._enter(ModulePhase.WAITING, f"{why}; it is started again")

    def _enter(self, phase: ModulePhase, why: str) -> None:
        self.phase, self.why = phase, why
        if phase is ModulePhase.STOPPED and not self.replaced_by:
            self._failure = ""
