"""Tests have an environment of their own, and the same examples in each run."""

from __future__ import annotations

import importlib
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
PROBE = "tests/misbehaving/environment_probe.py"
ODD = {
    "TMUX": "/tmp/tmux-0/default,1,0",
    "STY": "1.pts",
    "TERM": "dumb",
    "TERM_PROGRAM": "vscode",
    "COLUMNS": "43",
    "LINES": "7",
    "NO_COLOR": "1",
    "FORCE_COLOR": "3",
    "COLORTERM": "24bit",
    "LANG": "C",
    "LC_ALL": "POSIX",
    "LANGUAGE": "de",
    "TZ": "Asia/Kolkata",
    "CI": "1",
    "SSH_CONNECTION": "10.0.0.1 1 10.0.0.2 22",
    "SSH_AUTH_SOCK": "/nowhere",
    "DISPLAY": ":7",
    "HOME": "/nowhere",
    "LOGNAME": "somebody",
    "USER": "somebody",
    "SUDO_USER": "somebody",
    "XDG_RUNTIME_DIR": "/nowhere",
    "XDG_DATA_HOME": "/nowhere",
    "STATE_DIRECTORY": "/nowhere",
    "NOTIFY_SOCKET": "/nowhere",
    "LOGS_DIRECTORY": "/nowhere",
    "WATCHDOG_USEC": "1",
    "http_proxy": "http://127.0.0.1:9",
    "ALL_PROXY": "socks5://127.0.0.1:9",
    "NO_PROXY": "*",
    "PYTHONDONTWRITEBYTECODE": "1",
    "PYTHONUNBUFFERED": "1",
    "PYTHONIOENCODING": "latin-1",
    "PYTHONPATH": "/nowhere",
    "PYTHONWARNINGS": "error",
    "VTE_VERSION": "7000",
    "KITTY_WINDOW_ID": "1",
    "TEXTUAL_FPS": "1",
    "WT_SESSION": "1",
    "OPENBLAS_NUM_THREADS": "64",
}
ALLOWED = {
    *(
        "PATH",
        "TMPDIR",
        "LD_LIBRARY_PATH",
        "DYLD_LIBRARY_PATH",
        "PY_COLORS",
        "HOME",
        "LANG",
        "TERM",
    ),
    *("TZ", "LOGNAME", "OPENBLAS_NUM_THREADS", "XDG_RUNTIME_DIR", "XDG_STATE_HOME", "LC_CTYPE"),
    *("XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"),
}
FOR_TESTS = ("RUNE_", "HYPOTHESIS_PROFILE", "PYTEST_")


def _be_odd() -> None:
    os.umask(0o077)
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGCHLD):
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGUSR1, signal.SIGTERM))


@pytest.mark.parametrize("workers", [[], ["-n", "1"]], ids=["plain", "xdist"])
def test_tests_inherit_nothing_of_who_runs_them(tmp_path: Path, workers: list[str]) -> None:
    report = tmp_path / "report"
    subprocess.run(
        [sys.executable, "-m", "pytest", "-q", PROBE, "-p", "no:cacheprovider", *workers],
        env={"PATH": os.environ["PATH"], **ODD, "RUNE_PROBE": str(report)},
        cwd=ROOT,
        # The dispositions and the mask of signals are what a shell or nohup would set.
        preexec_fn=_be_odd,
        check=True,
        capture_output=True,
    )
    found = json.loads(report.read_text())
    variables = found["variables"]
    foreign = {name for name in variables if not name.startswith(FOR_TESTS)} - ALLOWED
    assert foreign == set()
    assert {name for name in ODD if variables.get(name) == ODD[name]} == set()
    assert found["umask"] == 0o022
    assert set(found["ignored"]) <= {signal.SIGPIPE, signal.SIGXFSZ}
    assert found["blocked"] == []


def test_examples_are_the_same_whatever_other_tests_have_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if os.environ.get("HYPOTHESIS_PROFILE") == "thorough":
        pytest.skip("make soak tries new examples each time")
    drawn: list[int] = []

    @settings(max_examples=300)
    @given(st.integers())
    def draw(number: int) -> None:
        drawn.append(number)

    draw()
    before, drawn[:] = list(drawn), []
    (tmp_path / "own_constants.py").write_text("NUMBERS = [97531, 86420, -97531, 13579, 24680]\n")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.import_module("own_constants")
    draw()
    assert drawn == before


OF_CHANCE = re.compile(
    r"\bos\.urandom\(|\buuid\.uuid[14]\(|\bsecrets\.\w+\(|\bSystemRandom\b"
    r"|\bRandom\(\)|\bdefault_rng\(\)|\bSeedSequence\(\)"
)
"""Results that differ in each run."""
GLOBAL_RANDOM = re.compile(r"(?<![\w.])random\.[a-z]\w*\(")
"""Functions of the module `random`, which nobody seeds; also methods of a variable of that name."""
EXCEPTED = {
    "tests/hub/robomon/test_warm_parent.py",  # forked processes must differ in what chance gives
    "tests/support/ros_node.py",  # each publisher has an identity of its own
    "tests/house/test_own_environment.py",
}


def test_no_test_depends_on_chance() -> None:
    found = []
    for path in sorted((ROOT / "tests").rglob("*.py")):
        name, text = str(path.relative_to(ROOT)), path.read_text()
        patterns = [OF_CHANCE, *([GLOBAL_RANDOM] if "\nimport random\n" in text else [])]
        if name not in EXCEPTED:
            found += [f"{name}: {each}" for one in patterns for each in one.findall(text)]
    assert found == [], "use random.Random(SEED)"
