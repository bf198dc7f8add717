"""The lifecycle of one module: from events and time to actions; pure."""

from __future__ import annotations

import enum
import math
from collections import deque

from hub.gcm.supervision import ModulePhase, keep_alive_s
from hub.robomon.module_table import ModuleSpec

_REMEMBERED = 8
"""Number of process ids of earlier starts whose late messages are ignored."""
_TERM_S = 0.5
"""Time after SIGTERM for a module that hangs and ignores commands [s]."""


class ProcessAction(enum.Enum):
    """An action on a module's process."""

    START = "start"
    COMMAND = "tell it to stop"
    TERMINATE = "send it SIGTERM"
    KILL = "send it SIGKILL"


_UNWANTED = "is wanted by nobody"
_ESCALATION = (ProcessAction.COMMAND, ProcessAction.TERMINATE, ProcessAction.KILL)


class ModuleLifecycle:
    """One module from its first start to its last end; every method gets the time [s].

    Attributes:
        spec: Its entry in the robot file.
        phase: Its phase.
        why: The reason for this phase, for people, after its name: "was stopped by order";
            empty: it has run since its first start.
        pid: Process id; 0: it has no process.
        since: Time of its last start, or of the attempt.
        starts: Number of its starts.
        provides: Its known capabilities.
        needs: The capabilities it needs, as far as known.
        asked: Whether the module itself reported them.
        held: Stopped by order: it starts only by order.
        pinned: Started by order: it runs even without wants.
        replaced_by: The module that does its work; empty: none.
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
        self._last_heard = 0.0
        self._announced_itself = False
        self._start_at = 0.0
        self._stopping_since = 0.0
        self._done = 0
        self._hanging = False
        self._deliberate = True
        self._wanted_until = -math.inf

    @property
    def up(self) -> bool:
        """Whether it has a process that should go on."""
        return self.phase in (ModulePhase.STARTING, ModulePhase.RUNNING)

    @property
    def has_process(self) -> bool:
        """Whether it has a process."""
        return self.up or self.phase is ModulePhase.STOPPING

    @property
    def keep_alive_s(self) -> float:
        """Silence after which it counts as hanging [s]; 0: it never announces itself."""
        given = self.spec.keep_alive_s
        return keep_alive_s(self.provides) if given is None else given

    @property
    def usable(self) -> bool:
        """Whether it runs or can be started."""
        return not self.held and self.phase is not ModulePhase.FAILED

    @property
    def failing(self) -> bool:
        """Whether it ended soon after its start, repeatedly."""
        return self.phase is ModulePhase.WAITING and self._early > 1

    @property
    def sound(self) -> bool:
        """Whether it runs, or can be started at once."""
        return self.usable and not self.failing

    def learned(self, provides: frozenset[str], needs: frozenset[str]) -> None:
        """Note the capabilities that the module reported."""
        self.provides, self.needs, self.asked = provides, needs, True

    def started(self, pid: int, now: float) -> None:
        """Note the start of its process."""
        self.pid, self.since, self._last_heard = pid, now, now
        self._announced_itself = False
        self.starts += 1
        if self.keep_alive_s > 0.0:
            self._enter(ModulePhase.STARTING, "was started")
        else:
            self._run()

    def not_started(self, why: str, now: float) -> None:
        """Note that the system could not start it."""
        self.since = now
        self._fail(why, now)

    def announced(self, pid: int, now: float) -> bool:
        """Note an announcement; False: it is from an earlier process, or from another.

        Without an announcement of its own, the process may have started the announcing one.
        """
        if not self.has_process:
            return False
        if pid == self.pid:
            self._announced_itself = True
        elif self._announced_itself or pid in self._earlier:
            return False
        self._last_heard = now
        if self.phase is ModulePhase.STARTING:
            self._run()
        return True

    def replace_by(self, other: str) -> None:
        """Let another module do its work until that one fails."""
        self.replaced_by = other
        phase = ModulePhase.STOPPED if self.phase is ModulePhase.WAITING else self.phase
        self._enter(phase, f"{self.why.partition(';')[0]}; {other} does its work")

    def skip_pause(self, now: float) -> None:
        """Forget times before `now` [s], after a pause of this process."""
        self._last_heard = max(self._last_heard, now)

    def over_limit(self, excess: str, now: float) -> None:
        """Note that it uses more than its limit."""
        if self.phase is ModulePhase.RUNNING:
            self._stop(excess, now, deliberate=False)

    def stop_by_order(self, now: float) -> None:
        """Stop it by order; only an order starts it again."""
        self.held, self.pinned, self.replaced_by = True, False, ""
        if self.up:
            self._stop("was stopped by order", now, deliberate=True)
        elif self.phase is ModulePhase.STOPPING:
            self._deliberate = True
        else:
            self._enter(ModulePhase.STOPPED, "was stopped by order")

    def start_by_order(self) -> None:
        """Start it by order, without earlier failures."""
        self.replaced_by = ""
        self.held, self.pinned = False, not self.spec.always
        self._ends.clear()
        self._failure, self._early = "", 0
        self._start_at = -math.inf
        if not self.has_process:
            self._enter(ModulePhase.STOPPED, "is started by order")

    def restart_by_order(self, now: float) -> None:
        """Restart it by order."""
        self.start_by_order()
        if self.up:
            self._stop("is restarted by order", now, deliberate=True)

    def ended(self, how: str, now: float) -> None:
        """Note the end of its process."""
        self._earlier.append(self.pid)
        self.pid = 0
        if self.phase is not ModulePhase.STOPPING:
            self._fail(how, now)
        elif self._deliberate:
            self._enter(ModulePhase.STOPPED, self.why)
        else:
            self._fail(self.why, now)

    def step(self, now: float, *, wanted: bool, ready: bool) -> ProcessAction | None:
        """The next action.

        Args:
            now: The time [s].
            wanted: Whether it should run.
            ready: Whether the capabilities it needs are provided.
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

    def check_silence(self, now: float) -> None:
        """Fail if it has been silent for too long."""
        longest = self.keep_alive_s
        if longest <= 0.0:
            return
        if (
            self.phase is ModulePhase.STARTING
            and now - self._last_heard > self.spec.start_timeout_s
        ):
            self._hang(f"did not announce itself in {self.spec.start_timeout_s:g} s", now)
        elif self.phase is ModulePhase.RUNNING and now - self._last_heard > longest:
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
        """The next step of its end, if it is due; each step comes once."""
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
        """Note a failure: set the time of its restart, or give it up."""
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
