"""`rune-hub` as a person types it, where it needs no hub."""

from __future__ import annotations

import shlex
from importlib.metadata import version

import pytest

from hub.cli import command_parser
from hub.sim.arena import load_arena
from tests.support.command_line import rune_hub


def test_it_tells_its_version() -> None:
    done = rune_hub("--version")
    assert (done.returncode, done.stdout) == (0, f"rune-hub {version('robot-user-nexus')}\n")


@pytest.mark.parametrize("command", ["sim-ros", "sim-autopilot"])
def test_the_example_of_the_help_is_taken(command: str) -> None:
    words = " ".join(rune_hub(command, "--help").stdout.split())
    example = shlex.split(words.partition("Example: rune-hub ")[2])
    assert example[0] == command
    options = command_parser().parse_args(example)
    assert load_arena(options.arena or "yellow").start is not None


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            "run x.toml --lisen 1",
            "rune-hub run: '--lisen' is no option here; did you mean --listen?",
        ),
        (
            "run x.toml --lisen=1",
            "rune-hub run: '--lisen' is no option here; did you mean --listen?",
        ),
        ("mission list --jsno", "'--jsno' is no option here; did you mean --json?"),
        ("list --zzz", "'--zzz' is no option here; rune-hub list --help says more"),
        ("list one", "'one' is one argument too many; rune-hub list --help says more"),
        ("--versoin", "rune-hub: '--versoin' is no option here; did you mean --version?"),
        ("--hub x list", "'--hub' is no option here; options follow the command"),
    ],
)
def test_unknown_options_get_a_hint(arguments: str, said: str) -> None:
    done = rune_hub(*arguments.split())
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
