"""The arguments of `rune study`: tasks, options and their values."""

from __future__ import annotations

from pathlib import Path

from hub.command_line import CommandParser, Commands, number_type
from rune_study.plan.study_spec import MOST_PARTICIPANTS

_participant = number_type(
    int, 1, MOST_PARTICIPANTS, f"participant's number, 1 to {MOST_PARTICIPANTS}"
)


def parser() -> CommandParser:
    """The parser of `rune study`."""
    parser = CommandParser(
        prog="rune study",
        description="Plan a study, run its sessions in this terminal, look how far it is.",
        epilog="docs/studies.md goes through a study from the first file to the last participant. "
        "Exit codes: 0 ok, 1 a fault, 2 wrong usage or study, 3 no hub.",
    )
    tasks = parser.add_subparsers(dest="task", required=True, metavar="COMMAND")
    _add(tasks, "new", "write a study of two conditions, to be edited")
    check = _add(tasks, "check", "report all that is wrong with a study, and its design in numbers")
    check.add_argument("--json", action="store_true", help="the design in one line, for machines")
    plan = _add(tasks, "plan", "show the order of conditions of each participant")
    form = plan.add_mutually_exclusive_group()
    form.add_argument("--csv", action="store_true", help="each trial a line, for spreadsheets")
    form.add_argument("--json", action="store_true", help="each step a line, for machines")
    plan.add_argument("--participant", type=_participant, metavar="N", help="this one only")
    plan.add_argument(
        "--unblind", action="store_true", help="name the conditions of a blind study too"
    )
    run = _add(tasks, "run", "run the session of a participant, or go on with it")
    run.add_argument(
        "--participant", type=_participant, metavar="N", required=True, help="the number"
    )
    run.add_argument(
        "--replaces",
        type=_participant,
        metavar="M",
        default=0,
        help="take over the order of participant M, who left the study",
    )
    run.add_argument(
        "--hub",
        action="append",
        default=[],
        metavar="HUB",
        help="HOST or HOST:PORT of a real robot, once for each; default: simulated robots",
    )
    run.add_argument(
        "--keys", type=Path, metavar="KEYS", help="your key's file, for robots on other machines"
    )
    watch = _add(tasks, "watch", "show a session to the experimenter, who can begin and end trials")
    watch.add_argument(
        "--participant", type=_participant, metavar="N", required=True, help="the number"
    )
    status = _add(tasks, "status", "show who did what, and who is next")
    status.add_argument("--json", action="store_true", help="each participant a line, for machines")
    _add_results(tasks)
    return parser


def _add_results(tasks: Commands) -> None:
    report = _add(tasks, "report", "compute all metrics from the recordings, and write a page")
    report.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="the page; default: DIR/report.html"
    )
    report.add_argument(
        "--unblind", action="store_true", help="name the conditions of a blind study"
    )
    export = _add(tasks, "export", "compute all metrics, and write tables with their dictionary")
    form = export.add_mutually_exclusive_group()
    form.add_argument(
        "--bids", action="store_true", help="folders and tables of BIDS; default: DIR/bids"
    )
    form.add_argument(
        "--xlsx", action="store_true", help="one spreadsheet file; default: DIR/derived/study.xlsx"
    )
    export.add_argument(
        "--unblind", action="store_true", help="name the conditions of a blind study"
    )
    export.add_argument(
        "-o", "--output", type=Path, metavar="PATH", help="folder or file; default: DIR/derived"
    )
    replay = _add(tasks, "replay", "show the recordings of a trial")
    replay.add_argument("participant", type=_participant, metavar="N", help="the participant")
    trial = number_type(int, 1, 1000, "trial's number, from 1")
    replay.add_argument("trial", type=trial, metavar="TRIAL", help="the number of the trial")
    simulate = _add(tasks, "simulate", "do the study with simulated operators, and write a page")
    operators = number_type(int, 1, 1000, "number of operators, 1 to 1000")
    simulate.add_argument(
        "--operators", type=operators, metavar="N", help="default: as many as participants"
    )
    simulate.add_argument(
        "--on",
        choices=["models", "hubs", "console"],
        default="models",
        help="what they work on: models of robots, which take no time; simulated robots; or the "
        "whole session with pages, questionnaires and console. The last two take as long as people",
    )
    simulate.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="FACTOR=LEVEL:NAME=FACTOR",
        help="link=rubble:interaction=1.25,tolerance=0.8; as often as needed",
    )
    simulate.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="default: DIR/simulated"
    )


def _add(tasks: Commands, name: str, meaning: str) -> CommandParser:
    task = tasks.add_parser(name, help=meaning, description=f"{meaning[0].upper()}{meaning[1:]}.")
    task.add_argument("folder", type=Path, metavar="DIR", help="folder of the study")
    return task
