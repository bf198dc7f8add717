"""The command `rune study`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from hub.command_line import ExitCode
from hub.plain_text import plain
from rune_study.arguments import parser
from rune_study.errors import StudyError

_LEFT = "the session is not complete; the same command goes on with it\n"


def main(arguments: Sequence[str]) -> int:
    """Run `rune study`; returns the exit code.

    Args:
        arguments: Those after `study`.

    Raises:
        StudyError: The study or its data cannot be used.
        ConsoleError: The console of a trial cannot run.
    """
    options = parser().parse_args(arguments)
    tasks = {
        "new": _new,
        "check": _check,
        "plan": _plan,
        "run": _run,
        "status": _status,
    }
    return tasks[options.task](options)


def _new(options: argparse.Namespace) -> int:
    from rune_study.plan.template import write_study

    for path in write_study(options.folder):
        sys.stdout.write(f"{plain(str(path))}\n")
    sys.stdout.write(f"next: edit study.toml, then rune study check {plain(str(options.folder))}\n")
    return ExitCode.OK


def _check(options: argparse.Namespace) -> int:
    from rune_study.plan.checking import as_json, design_lines, design_report, missing
    from rune_study.plan.study_file import read_study

    study = read_study(options.folder)
    report, problems = design_report(study), missing(study)
    if options.json:
        sys.stdout.write(as_json(report) + "\n")
    else:
        sys.stdout.writelines(f"{plain(line)}\n" for line in design_lines(report))
    sys.stderr.writelines(f"note: {plain(each)}\n" for each in report.warnings)
    sys.stderr.writelines(f"rune: {plain(each, lines=True)}\n" for each in problems)
    unreachable = report.tries and not report.kept
    return ExitCode.USAGE if problems or unreachable else ExitCode.OK


def _plan(options: argparse.Namespace) -> int:
    from rune_study.plan.study_file import read_study
    from rune_study.plan.tables import as_csv, as_lines, json_lines

    study = read_study(options.folder)
    one = options.participant
    chosen = [one] if one else list(range(1, study.participants + 1))
    make = as_csv if options.csv else json_lines if options.json else as_lines
    named = options.unblind or not study.design.blind
    sys.stdout.writelines(f"{line}\n" for line in make(study, chosen, named=named))
    return ExitCode.OK


def _run(options: argparse.Namespace) -> int:
    from hub.ipc.endpoints import endpoint_of
    from rune_study.plan.study_file import read_study
    from rune_study.session.journal import Journal
    from rune_study.session.session import Session

    study = read_study(options.folder)
    if not all(stream.isatty() for stream in (sys.stdin, sys.stdout)):
        text = "a session needs a terminal; open one of at least 80x24"
        raise StudyError(text)
    hubs = [endpoint_of(hub) for hub in options.hub]
    with Journal.of(study, options.participant, options.replaces) as journal:
        complete = Session(study, journal, options.participant, hubs).run()
    sys.stdout.write("the session is complete\n" if complete else _LEFT)
    return ExitCode.OK if complete else ExitCode.FAULT


def _status(options: argparse.Namespace) -> int:
    import dataclasses
    import json

    from rune_study.plan.study_file import read_study
    from rune_study.session.status import participants_of, progress_of, status_lines

    study = read_study(options.folder)
    if options.json:
        for participant in participants_of(study):
            progress = dataclasses.asdict(progress_of(study, participant))
            sys.stdout.write(json.dumps(progress) + "\n")
    else:
        sys.stdout.writelines(f"{plain(line)}\n" for line in status_lines(study))
    return ExitCode.OK
