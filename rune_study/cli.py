"""The command `rune study`."""

from __future__ import annotations

import argparse
import datetime
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from hub import files
from hub.command_line import ExitCode
from hub.plain_text import plain
from rune_study.arguments import parser
from rune_study.errors import StudyError, TrialError
from rune_study.plan.study_spec import StudySpec

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
        "watch": _watch,
        "status": _status,
        "report": _report,
        "export": _export,
        "replay": _replay,
        "simulate": _simulate,
    }
    return tasks[options.task](options)


def _new(options: argparse.Namespace) -> int:
    from rune_study.plan.template import write_study

    for path in write_study(options.folder):
        sys.stdout.write(f"{plain(str(path))}\n")
    sys.stdout.write(f"next: edit study.toml, then rune study check {plain(str(options.folder))}\n")
    return ExitCode.OK


def _check(options: argparse.Namespace) -> int:
    import json

    from rune_study.plan.checking import check_study, unmeasured
    from rune_study.plan.conditions import not_kept
    from rune_study.plan.design_report import as_data, design_lines, design_report
    from rune_study.plan.study_file import refuse

    draft = check_study(options.folder)
    if draft.problems:
        if options.json:
            sys.stdout.write(json.dumps({"problems": draft.problems}) + "\n")
        refuse(options.folder, draft.problems)
    report = design_report(draft.study)
    notes = [*report.warnings, *unmeasured(draft.study), *not_kept(draft.study)]
    if options.json:
        whole = {**as_data(report), "warnings": notes, "problems": []}
        sys.stdout.write(json.dumps(whole) + "\n")
    else:
        sys.stdout.writelines(f"{plain(line)}\n" for line in design_lines(report))
    sys.stderr.writelines(f"note: {plain(each)}\n" for each in notes)
    unreachable = report.tries and not report.kept
    return ExitCode.USAGE if unreachable else ExitCode.OK


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
    from rune_study.plan.blinding import write_key
    from rune_study.plan.real_robots import RealRobots
    from rune_study.plan.study_file import read_study
    from rune_study.session.journal import Journal, participants_of
    from rune_study.session.session import Session
    from rune_study.session.status import next_participant

    study = read_study(options.folder)
    _need_terminal()
    write_key(study)
    hubs = tuple(endpoint_of(hub) for hub in options.hub)
    real = RealRobots(hubs=hubs, keys=options.keys)
    with Journal.of(study, options.participant, options.replaces) as journal:
        _warn(study, [options.participant])
        session = Session(study, journal, options.participant, real)
        try:
            complete = not journal.declined and session.run()
        except TrialError as error:
            sys.stderr.write(f"rune: {plain(str(error))}\n")
            return ExitCode.FAULT
        declined, order = journal.declined, journal.replaces or options.participant
    if declined:
        free = next_participant(participants_of(study))
        sys.stdout.write(
            f"participant {options.participant} declined to take part; another person takes over: "
            f"rune study run {plain(str(options.folder))} --participant {free} --replaces {order}\n"
        )
        return ExitCode.FAULT
    sys.stdout.write("the session is complete\n" if complete else _LEFT)
    return ExitCode.OK if complete else ExitCode.FAULT


def _watch(options: argparse.Namespace) -> int:
    from rune_study.plan.study_file import read_study
    from rune_study.session.watching import WatchScreen

    study = read_study(options.folder)
    _need_terminal()
    WatchScreen(study, options.participant).run()
    return ExitCode.OK


def _need_terminal() -> None:
    if not all(stream.isatty() for stream in (sys.stdin, sys.stdout)):
        text = "this needs a terminal; open one of at least 80x24"
        raise StudyError(text)


def _status(options: argparse.Namespace) -> int:
    import dataclasses
    import json

    from rune_study.plan.study_file import read_study
    from rune_study.session.journal import participants_of
    from rune_study.session.status import progress_of, status_lines

    study = read_study(options.folder)
    _warn(study, participants_of(study))
    if options.json:
        for participant in participants_of(study):
            progress = dataclasses.asdict(progress_of(study, participant))
            sys.stdout.write(json.dumps(progress) + "\n")
    else:
        sys.stdout.writelines(f"{plain(line)}\n" for line in status_lines(study))
    return ExitCode.OK


def _report(options: argparse.Namespace) -> int:
    from rune_study.data.store import checksums, compute
    from rune_study.plan.study_file import read_study
    from rune_study.report.making import make_page, unblinded
    from rune_study.session.journal import participants_of
    from rune_study.session.status import progress_of, state_words

    study = read_study(options.folder)
    begun = participants_of(study)
    warnings = _warn(study, begun)
    data = compute(study, _progress("computing metrics"))
    warnings += _say(data.partial)
    if options.unblind:
        unblinded(study)
    page = make_page(
        study,
        data,
        made=f"{datetime.datetime.now().astimezone():%Y-%m-%d %H:%M}",
        source=f"rune study report {options.folder} computes all of it from the recordings.",
        unblind=options.unblind,
        warnings=warnings,
        sessions={each: state_words(progress_of(study, each)) for each in begun},
        checksums=checksums(study),
    )
    return _written(options.output or study.folder / "report.html", page)


def _export(options: argparse.Namespace) -> int:
    from rune_study.data.bids import write_bids
    from rune_study.data.store import DERIVED, compute, write_tables
    from rune_study.data.xlsx import write_xlsx
    from rune_study.plan.study_file import read_study
    from rune_study.report.making import unblinded
    from rune_study.session.journal import participants_of

    study = read_study(options.folder)
    _warn(study, participants_of(study))
    data = compute(study, _progress("computing metrics"))
    _say(data.partial)
    if options.unblind:
        unblinded(study)
    if options.bids:
        named = options.unblind or not study.design.blind
        written = write_bids(study, data, options.output or study.folder / "bids", named=named)
    elif options.xlsx:
        written = [write_xlsx(data, options.output or study.folder / DERIVED / "study.xlsx")]
    else:
        written = write_tables(options.output or study.folder / DERIVED, data)
    sys.stdout.writelines(f"{plain(str(path))}\n" for path in written)
    return ExitCode.OK


def _replay(options: argparse.Namespace) -> int:
    from rune_study.data.store import recordings_of
    from rune_study.plan.study_file import read_study

    files = recordings_of(read_study(options.folder), options.participant, options.trial)
    command = [sys.executable, "-m", "rune_tui", "replay", *map(str, files)]
    return subprocess.run(command, check=False).returncode


def _simulate(options: argparse.Namespace) -> int:
    from rune_study.data.store import StudyData, write_tables
    from rune_study.plan.study_file import read_study
    from rune_study.report.making import make_page
    from rune_study.simulate.model_study import effect_of, simulated
    from rune_study.simulate.operator_model import OperatorModel

    study = read_study(options.folder)
    if options.on != "models":
        return _simulate_in_real_time(study, options)
    effects = [effect_of(each) for each in options.effect]
    operators = options.operators or study.participants
    trials, metrics = simulated(study, operators, OperatorModel(check_s=40.0), effects)
    folder = options.output or study.folder / "simulated"
    data = StudyData(trials=tuple(trials), metrics=tuple(metrics))
    write_tables(folder, data)
    words = "; ".join(options.effect) or "no effect of any condition"
    page = make_page(
        study,
        data,
        made="by models",
        source=f"Models took the place of people ({words}); nobody drove a robot.",
        unblind=True,
    )
    return _written(folder / "report.html", page)


def _simulate_in_real_time(study: StudySpec, options: argparse.Namespace) -> int:
    from rune_study.data.store import DERIVED, write_tables
    from rune_study.report.making import make_page
    from rune_study.simulate.agreement import agreement_lines, counts_agree
    from rune_study.simulate.console_study import play_on_consoles
    from rune_study.simulate.hub_study import play_on_hubs
    from rune_study.simulate.script import IN_REAL_TIME

    if options.effect:
        text = f"--effect is for models, and not for --on {options.on}"
        raise StudyError(text)
    play = play_on_hubs if options.on == "hubs" else play_on_consoles
    folder = options.output or study.folder / f"simulated-on-{options.on}"
    operators = options.operators or study.participants

    def tell(line: str) -> None:
        sys.stderr.write(f"{line}\n")

    played = play(study, folder, operators, IN_REAL_TIME, tell)
    write_tables(folder / DERIVED, played.data)
    page = make_page(
        played.study,
        played.data,
        made=f"by a script on {options.on}",
        source=f"A script took the place of people, on {options.on}.",
        unblind=True,
    )
    sys.stdout.writelines(f"{line}\n" for line in agreement_lines(played.found))
    sys.stderr.writelines(f"rune: {plain(each)}\n" for each in played.wrong)
    _written(folder / "report.html", page)
    fits = counts_agree(played.found) and not played.wrong
    return ExitCode.OK if fits else ExitCode.FAULT


def _warn(study: StudySpec, participants: Sequence[int]) -> list[str]:
    """Say on stderr what is wrong with participants' files; returns the same."""
    from rune_study.session.warnings import warnings_of

    return _say(warnings_of(study, participants))


def _say(notes: Iterable[str]) -> list[str]:
    said = [plain(each) for each in notes]
    sys.stderr.writelines(f"note: {each}\n" for each in said)
    return said


def _written(path: Path, text: str) -> int:
    files.write_output(path, text.encode())
    sys.stdout.write(f"{plain(str(path))}\n")
    return ExitCode.OK


def _progress(words: str) -> Callable[[float], None]:
    def show(share: float) -> None:
        if sys.stderr.isatty():
            end = "\n" if share >= 1 else ""
            sys.stderr.write(f"\r{words}: {100 * share:.0f} %{end}")
            sys.stderr.flush()

    return show
