"""A trial from the first moment in which control is possible to its end."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from hub.command_line import ExitCode
from hub.errors import CentralUnreachableError
from hub.values import dataclass
from rune_study.plan.measures import measures
from rune_study.plan.practice import Criterion
from rune_study.plan.steps import Step
from rune_study.plan.study_spec import PracticeSpec, StudySpec
from rune_study.session.interruptions import Interruptions
from rune_study.session.journal import Journal, pauses_of
from rune_study.session.live import LiveSigns
from rune_study.session.orders import ABORT, BEGIN, END, MARK, NOTE, PAUSE, OrderBook
from rune_study.session.practice_meter import PracticeFiles, PracticeMeter
from rune_study.session.progress import LeftError, Result
from rune_study.session.reading import read
from rune_study.session.robots import listening, state_of
from rune_study.session.schedule import Schedule
from rune_study.session.stage import Stage, part_of

_LOOK_S = 0.02
_PAUSED = "# Pause\n\nThe trial goes on when the experimenter says so."


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How a trial ended.

    Attributes:
        why: `time`, `victims`, `collisions`, `operator`, `experimenter`, `criterion`, or why it
            does not count.
        counts: Whether it is done; else it begins again.
    """

    why: str
    counts: bool = True


class Trial:
    """A running trial, or practice.

    Attributes:
        failure: Why it does not count; empty: it does, or it runs.
    """

    def __init__(
        self,
        study: StudySpec,
        step: Step,
        attempt: int,
        journal: Journal,
        stage: Stage,
        book: OrderBook,
        mark: Callable[[str], None],
    ) -> None:
        """Prepare.

        Args:
            study: The study.
            step: The trial.
            attempt: Its number.
            journal: Gets all that happens.
            stage: The running parts.
            book: Orders of the experimenter.
            mark: Sends a marker to other instruments.
        """
        self._study = study
        self._step = step
        self._journal = journal
        self._stage = stage
        self._book = book
        self._mark = mark
        self._interruptions = Interruptions(study, step, attempt, journal, stage)
        self._practice = None if step.trial else study.practice
        self._criterion = (
            Criterion.read(self._practice.criterion)
            if self._practice is not None and self._practice.criterion
            else None
        )
        *hubs, console = stage.files
        files = PracticeFiles(
            consoles=part_of(console),
            hubs=hubs,
            arena=stage.arena,
            effectiveness=study.metrics.effectiveness,
            measures=measures(study),
        )
        self._meter = PracticeMeter(files, self._criterion.metrics if self._criterion else ())
        self._lately: Mapping[str, float] = {}
        self.failure = ""
        self._signs = LiveSigns(journal.path.parent)
        self._window: deque[tuple[float, float, int]] = deque()

    def run(self) -> Result | None:
        """Run it to its end; returns its result; None: it does not count.

        Raises:
            LeftError: The session was left.
        """
        with listening(self._stage.robots):
            ready = self._stage.console.wait_for("ready")
        if not ready:
            self.failure = "the console did not start"
            self._note("lost", why=self.failure, code=self._stage.console.exit_code)
            return None
        for robot in self._stage.robots:
            robot.watch(_LOOK_S)
            robot.begin()
        now = time.monotonic()
        schedule = Schedule(self._step, now)
        self._note("trial-begin", moment_s=now, **self._stage.limits)
        self._mark(f"begin {self._step.name} {self._step.code}".strip())
        try:
            ending = self._loop(schedule)
        except CentralUnreachableError as lost:
            ending = Ending(why=str(lost), counts=False)
        self._interruptions.close()
        self._meter.close()
        seconds = schedule.elapsed(time.monotonic())
        self._mark(f"end {self._step.name} {ending.why}")
        robots = [state_of(robot) for robot in self._stage.robots]
        if self._criterion is not None:
            values = {
                each.quantity: _known(self._lately.get(each.quantity))
                for each in self._criterion.clauses
            }
            self._note("criterion", met=ending.why == "criterion", values=values)
        self._note("trial-end", why=ending.why, seconds=seconds, robots=robots)
        if not ending.counts:
            self.failure = ending.why
            return None
        files = [file.name for file in self._stage.files]
        result = {"ended": ending.why, "seconds": round(seconds, 3), "robots": robots}
        return {**result, "begun": now, "files": files, **self._passed(ending)}

    def _loop(self, schedule: Schedule) -> Ending:
        while True:
            for robot in self._stage.robots:
                robot.watch(_LOOK_S / len(self._stage.robots))
            for report in self._stage.console.reports():
                if report.get("event") == "key":
                    self._interruptions.answer(str(report["name"]), float(report["moment"]))
                elif report.get("event") == "withheld":
                    self._interruptions.withheld()
            ending = self._ordered(schedule) or self._ending(schedule)
            if ending is not None:
                return ending
            now = time.monotonic()
            for due in schedule.due(now, withheld=self._interruptions.withholds):
                self._mark(f"{due.what} {due.number}")
                self._interruptions.begin(due, schedule)
            self._interruptions.look(now)
            self._signs.tell(self._stage.robots)

    def _ordered(self, schedule: Schedule) -> Ending | None:
        for order in self._book.fresh():
            self._note("order", do=order.do, text=order.text, given=order.at)
            if order.do in (MARK, NOTE):
                self._mark(f"{order.do} {order.text}".strip())
            elif order.do == PAUSE:
                self._pause(schedule)
            elif order.do == END:
                return Ending(why="experimenter")
            elif order.do == ABORT:
                why = "the experimenter left the session"
                raise LeftError(why)
        return None

    def _pause(self, schedule: Schedule) -> None:
        self._interruptions.pause(schedule)
        with listening(self._stage.robots):
            read(_PAUSED, ended=lambda: self._is_ordered(BEGIN))
        self._note("order", do=BEGIN, text="", given=time.time())
        self._interruptions.go_on(schedule)

    def _is_ordered(self, do: str) -> bool:
        orders = self._book.fresh()
        if any(order.do == ABORT for order in orders):
            why = "the experimenter left the session"
            raise LeftError(why)
        return any(order.do == do for order in orders)

    def _ending(self, schedule: Schedule) -> Ending | None:
        elapsed = schedule.elapsed(time.monotonic())
        if not self._stage.console.running:
            return self._console_ended()
        broken = self._stage.broken(time.monotonic())
        if broken:
            return Ending(why=broken, counts=False)
        if elapsed >= self._step.seconds:
            return Ending(why="time")
        if self._practice is not None:
            met = self._meets(self._practice, schedule)
            return Ending(why="criterion") if met else None
        robots, ends = self._stage.robots, self._study.trial.ends
        victims = max((robot.number_of_victims for robot in robots), default=0)
        if "victims" in ends and victims and max(each.victims for each in robots) == victims:
            return Ending(why="victims")
        collisions = sum(robot.collisions for robot in robots)
        if "collisions" in ends and collisions >= self._study.trial.collisions:
            return Ending(why="collisions")
        return None

    def _console_ended(self) -> Ending:
        if self._stage.console.exit_code not in (ExitCode.OK, ExitCode.NOT_KEPT):
            return Ending(why="the console failed", counts=False)
        counts = self._practice is not None or "operator" in self._study.trial.ends
        return Ending(why="operator", counts=counts)

    def _meets(self, spec: PracticeSpec, schedule: Schedule) -> bool:
        """Whether the criterion of practice holds over the last part of it."""
        now = time.monotonic()
        elapsed = schedule.elapsed(now)
        pauses = pauses_of(self._journal.records)
        self._meter.look(schedule.moment(max(0.0, elapsed - spec.window_s), pauses), now, pauses)
        robots = self._stage.robots
        driven = sum(robot.distance for robot in robots)
        collisions = sum(robot.collisions for robot in robots)
        self._window.append((elapsed, driven, collisions))
        while self._window[0][0] < elapsed - spec.window_s:
            self._window.popleft()
        first = self._window[0]
        self._lately = {
            **self._meter.values,
            "distance": driven - first[1],
            "collisions": collisions - first[2],
            "victims": max(robot.victims for robot in robots),
            "seconds": elapsed,
        }
        enough = elapsed >= spec.least_s
        return self._criterion is not None and enough and self._criterion.holds(self._lately)

    def _passed(self, ending: Ending) -> dict[str, bool]:
        if self._practice is None:
            return {}
        without = not self._practice.criterion
        return {"passed": without or ending.why == "criterion"}

    def _note(self, what: str, **data: Any) -> None:  # noqa: ANN401 - what JSON has
        self._journal.put(what, n=self._step.number, **data)


def _known(value: float | None) -> float | None:
    """A number as a journal has it; None: it is not known."""
    return round(value, 6) if value is not None and math.isfinite(value) else None
