"""Rules of the house that no linter knows."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted(p for package in ("hub", "rune_tui") for p in (ROOT / package).rglob("*.py"))
MAX_LINES = 500
VAGUE = {"util", "utils", "helper", "helpers", "misc", "core", "base", "types", "manager"}


def _name(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_file_is_small_and_named_for_what_it_holds(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= MAX_LINES
    assert path.stem.strip("_") not in VAGUE


@pytest.mark.parametrize("path", [p for p in SOURCES if p.name == "__init__.py"], ids=_name)
def test_package_init_holds_only_a_docstring(path: Path) -> None:
    body = ast.parse(path.read_text()).body
    assert [type(node) for node in body] == [ast.Expr]


def test_every_dependency_is_bounded_and_has_its_reason_beside_it() -> None:
    text = (ROOT / "pyproject.toml").read_text()
    project = tomllib.loads(text)
    names = [*project["project"]["dependencies"], *project["dependency-groups"]["dev"]]
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
    lock = (ROOT / "requirements.lock").read_text()
    assert "://" not in lock
    assert all(f"\n{name}==" in lock for name in ("numpy", "pyzmq", "textual", "pytest"))
