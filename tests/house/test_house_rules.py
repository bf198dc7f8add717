"""Rules of the house that no linter knows."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = sorted(
    p for package in ("hub", "rune_study", "rune_tui") for p in (ROOT / package).rglob("*.py")
)
TESTS = sorted(p for room in ("benchmarks", "tests") for p in (ROOT / room).rglob("*.py"))
MAX_LINES = 500
VAGUE = {"util", "utils", "helper", "helpers", "misc", "core", "base", "types", "manager"}


def test_files_are_small_and_named_for_what_they_hold() -> None:
    lines = {path: len(path.read_text().splitlines()) for path in (*SOURCES, *TESTS)}
    assert {path: count for path, count in lines.items() if count > MAX_LINES} == {}
    assert [path for path in SOURCES if path.stem.strip("_") in VAGUE] == []


def test_package_inits_hold_only_a_docstring() -> None:
    bodies = {
        path: [type(node) for node in ast.parse(path.read_text()).body]
        for path in SOURCES
        if path.name == "__init__.py"
    }
    assert {path: body for path, body in bodies.items() if body != [ast.Expr]} == {}


def test_every_dependency_is_bounded_and_has_its_reason_beside_it() -> None:
    text = (ROOT / "pyproject.toml").read_text()
    project = tomllib.loads(text)
    groups = project["dependency-groups"].values()
    grouped = [each for group in groups for each in group if isinstance(each, str)]
    names = [*project["project"]["dependencies"], *grouped]
    for extra in project["project"]["optional-dependencies"].values():
        names += extra
    unexplained = [
        line.strip()
        for line in text.splitlines()
        if any(line.strip().startswith(f'"{name}"') for name in names) and "#" not in line
    ]
    assert all("<" in name for name in names)
    # The test tools that speak for themselves by their name.
    assert unexplained == ['"pytest>=9,<10",']


def test_locked_versions_name_no_registry() -> None:
    whole, demo = ((ROOT / f"requirements{each}.lock").read_text() for each in ("", "-demo"))
    assert "://" not in whole + demo
    assert all(f"\n{name}==" in whole for name in ("numpy", "pyzmq", "textual", "pytest"))
    assert set(re.findall(r"^\S+==.*$", demo, re.MULTILINE)) < set(
        re.findall(r"^\S+==.*$", whole, re.MULTILINE)
    )
