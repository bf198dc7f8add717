"""Common parts of both commands: arguments, exit codes, the version, completion in shells."""

from __future__ import annotations

import argparse
import contextlib
import enum
import getpass
import os
import re
import signal
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn, TypeAlias, TypeVar

from hub.nearest import did_you_mean, nearest_word
from hub.plain_text import plain

N = TypeVar("N", int, float)

DISTRIBUTION = "robot-user-nexus"
_UNKNOWN = re.compile(r"invalid choice: '(?P<word>[^']{1,64})' \(choose from (?P<known>.*)\)")


def ending_signals() -> list[int]:
    """The signals that end a program; without SIGHUP where it is ignored, as under nohup."""
    numbers = [signal.SIGINT, signal.SIGTERM]
    hangup = getattr(signal, "SIGHUP", None)
    if hangup is not None and signal.getsignal(hangup) is not signal.SIG_IGN:
        numbers.append(hangup)
    return list(map(int, numbers))


class ExitCode(enum.IntEnum):
    """The exit code of a command.

    Attributes:
        OK: It succeeded.
        FAULT: It failed, or the hub refused it.
        USAGE: The arguments, a layout or a robot file are wrong.
        NO_HUB: No hub answers.
        NOT_KEPT: It ended as it should, and its recording lacks something.
    """

    OK = 0
    FAULT = 1
    USAGE = 2
    NO_HUB = 3
    NOT_KEPT = 4


def leave(code: ExitCode) -> NoReturn:
    """End at once: Ctrl-C can interrupt the making of sockets, and closing them would wait."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(code)


class CommandParser(argparse.ArgumentParser):
    """Suggests the nearest known word or option, and shows the help when a command is missing.

    Attributes:
        advice: Remedy after an error; empty: the help.
    """

    advice = ""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Like `argparse`, but unknown arguments are errors: only this parser has its options."""
        words = list(sys.argv[1:] if args is None else args)
        if self._subparsers and words and self._is_unknown(words[0]):
            self.error(self._usage_error(words, or_else="; options follow the command"))
        found, unknown = super().parse_known_args(words, namespace)
        if unknown:
            self.error(self._usage_error(unknown))
        return found, unknown

    def _is_unknown(self, word: str) -> bool:
        """Whether it has the form of an option, and is none of this parser's."""
        name = word.partition("=")[0]
        known = any(option.startswith(name) for option in self._option_string_actions)
        return name.startswith("-") and not known

    def _usage_error(self, unknown: Sequence[str], or_else: str = "") -> str:
        option = next((word.partition("=")[0] for word in unknown if word.startswith("-")), "")
        if not option:
            return f"{unknown[0]!r} is one argument too many"
        names = {name.lstrip("-"): name for name in self._option_string_actions}
        near = nearest_word(option.lstrip("-"), names)
        hint = f"; did you mean {names[near]}?" if near else or_else
        return f"{option!r} is no option here{hint}"

    def error(self, message: str) -> NoReturn:
        """Print the mistake in the arguments in one sentence, and end with code 2."""
        if message.startswith("the following arguments are required: COMMAND"):
            self.print_help(sys.stderr)
            self.exit(ExitCode.USAGE)
        if wrong := _UNKNOWN.search(message):
            known = re.findall(r"'([^']+)'", wrong["known"]) or wrong["known"].split(", ")
            message = message[: wrong.start()] + _unknown(wrong["word"], known)
        advice = self.advice or f"{self.prog} --help says more"
        more = "" if message.endswith("?") else f"; {advice}"
        self.exit(ExitCode.USAGE, plain(f"{self.prog}: {message}{more}", lines=True) + "\n")


Commands: TypeAlias = "argparse._SubParsersAction[CommandParser]"  # noqa: SLF001 - it has no public name
"""The place of further commands."""


class ShowVersion(argparse.Action):
    """Finds the version only on request: its import costs 30 ms."""

    def __init__(self, option_strings: Sequence[str], dest: str) -> None:
        text = "show the version and exit"
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, help=text)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print the version and end."""
        from importlib.metadata import version

        sys.stdout.write(f"{parser.prog} {version(DISTRIBUTION)}\n")
        parser.exit()


def number_type(
    kind: Callable[[str], N], least: float, most: float, allowed: str
) -> Callable[[str], N]:
    """A reader of a number argument.

    Args:
        kind: Converts the text: int or float.
        least: Smallest value allowed.
        most: Largest value allowed.
        allowed: The allowed arguments, in words.
    """

    def read(text: str) -> N:
        with contextlib.suppress(ValueError):
            number = kind(text)
            if least <= number <= most:
                return number
        reason = f"{text!r} is no {allowed}"
        raise argparse.ArgumentTypeError(reason)

    return read


def login_name() -> str:
    """The login's name; empty: the system has none."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return ""


def add_completion(commands: Commands) -> None:
    """Add the command that prints the script for completion in a shell."""
    completion = commands.add_parser(
        "completion",
        help="print what completes this command's words in your shell",
        description="Print a script that completes this command's words. For bash, write it to "
        "~/.local/share/bash-completion/completions/ under the command's name; for zsh, to a "
        "folder of $fpath under its name with _ before it.",
    )
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"))


def write_completion(parser: Callable[[], CommandParser], shell: str) -> int:
    """Write the script that completes a command's words to standard output."""
    import shtab

    sys.stdout.write(shtab.complete(parser(), shell=shell) + "\n")
    return ExitCode.OK


def _unknown(word: str, known: Sequence[str]) -> str:
    hint = did_you_mean(word, known)
    return f"{word!r} is unknown" + (hint or f"; it has to be one of {', '.join(known)}")
