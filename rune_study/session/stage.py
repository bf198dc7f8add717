"""What a trial happens on: robots with their hubs, links and recordings, and the console."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path

from hub.shaper.shaped_link import ShapedLink
from hub.values import dataclass
from rune_study.plan.conditions import limit_words, limits_of
from rune_study.plan.folder import arena_of, hub_settings, layout_of, link_of, robot_of
from rune_study.plan.real_robots import RealRobots
from rune_study.plan.steps import Step
from rune_study.plan.study_spec import ConditionSpec, StudySpec
from rune_study.session.conducting import ConsoleProcess, console_options
from rune_study.session.robots import Recorders, WatchedRobot, simulated
from rune_study.trial_data.truth import truth_of

LOG = "session.log"
"""What hubs and recorders said, in the participant's folder."""
SILENT_S = 10.0
"""A robot that says nothing for longer has no trial [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """The running parts of a trial.

    Attributes:
        console: The console.
        robots: The robots, in the order of the layout.
        recorders: Of the hubs.
        links: Bad links of the condition; none: links are as they are.
        files: Recordings of the hubs, and last the one of the console, which may not exist yet.
        arena: Name or path of the arena; empty: it is not known.
        limits: Levels of autonomy and assistance, by their keys; none in a blind study.
    """

    console: ConsoleProcess
    robots: tuple[WatchedRobot, ...]
    recorders: Recorders
    links: tuple[ShapedLink, ...]
    files: tuple[Path, ...]
    arena: str
    limits: Mapping[str, str]

    def broken(self, now: float) -> str:
        """Which part has ended, so that the trial does not count; empty: all run."""
        for number, robot in enumerate(self.robots, 1):
            if robot.silent_for(now) > SILENT_S:
                return f"robot {number} says nothing"
        if self.recorders.ended:
            return f"the recorder of {self.recorders.ended} has ended"
        if any(link.ended for link in self.links):
            return "the link shaper has ended"
        return ""


def names_of_files(folder: Path, name: str, attempt: int, robots: int) -> tuple[Path, ...]:
    """Recordings of a trial's attempt: of each hub, and last of the console."""
    begin = f"{name}-a{attempt}"
    hubs = [f"{begin}.mcap"] if robots == 1 else [f"{begin}.r{n + 1}.mcap" for n in range(robots)]
    return tuple(folder / each for each in (*hubs, f"{begin}.console.mcap"))


@contextlib.contextmanager
def stage(
    study: StudySpec,
    spec: ConditionSpec,
    step: Step,
    *,
    folder: Path,
    operator: str,
    attempt: int,
    real: RealRobots,
) -> Iterator[Stage]:
    """Start all parts, and end them with the context.

    Args:
        study: The study.
        spec: The condition.
        step: The trial, for its seeds.
        folder: Of the participant.
        operator: The participant's code.
        attempt: Number of the attempt.
        real: The real robots of the condition, if it has any.

    Raises:
        HubError: A hub, a link or the console cannot be started, or a robot cannot be reached.
        OwnHubError: A simulated robot did not start.
    """
    log = folder / LOG
    *recordings, of_console = names_of_files(folder, step.name, attempt, spec.robots)
    victims = truth_of(arena_of(study, spec)).victims_in_map() if spec.arena else []
    with contextlib.ExitStack() as stack:
        if real.hubs:
            own = list(real.hubs)
        else:
            robots = [robot_of(study, spec)] * spec.robots
            settings = hub_settings(study, spec, step.seed)
            own = stack.enter_context(simulated(robots, settings, log))
        recorders = stack.enter_context(Recorders(own, recordings, log, real.keys))
        links: tuple[ShapedLink, ...] = ()
        if spec.link:
            profile, seed = link_of(study, spec), step.link_seed
            links = tuple(
                stack.enter_context(ShapedLink(hub, profile, seed, keys=real.keys)) for hub in own
            )
        watched = tuple(
            stack.enter_context(
                WatchedRobot(
                    hub,
                    number,
                    victims,
                    metrics=study.metrics,
                    real=bool(real.hubs),
                    keys=real.keys,
                )
            )
            for number, hub in enumerate(own)
        )
        seen = [link.endpoint for link in links] or own
        part = part_of(of_console)
        stack.callback(_keep, part, of_console)
        limits = str(limits_of(spec))
        options = console_options(seen, operator, part, spec.variables, limits, real.keys)
        console = stack.enter_context(ConsoleProcess(layout_of(study, spec), options))
        yield Stage(
            console=console,
            robots=watched,
            recorders=recorders,
            links=links,
            files=(*recordings, of_console),
            arena=arena_of(study, spec),
            limits={} if study.design.blind else limit_words(spec),
        )


def part_of(console: Path) -> Path:
    """Folder in which the console's recording is until its end."""
    return console.with_suffix(".part")


def _keep(part: Path, file: Path) -> None:
    """Give the console's recording its name; a folder with other files stays."""
    found = sorted(part.glob("*.mcap"))
    if len(found) == 1 and not file.exists():
        found[0].rename(file)
    with contextlib.suppress(OSError):
        part.rmdir()
