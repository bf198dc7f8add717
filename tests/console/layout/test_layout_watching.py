"""Layouts that are saved while they are open: good ones are taken, bad ones said."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rune_tui.errors import LayoutError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import LayoutSource, first_problem
from rune_tui.startup.opening import open_layout

TEXT = """<rune run="{run}">
  <robot name="magellan"/>
  <include file="view.xml"/>
</rune>
"""
PART = '<part><view xsize="{size}" ysize="48"/></part>'


@pytest.fixture
def layouts(tmp_path: Path) -> list[str]:
    """Paths of two layouts that share a part."""
    for number, name in enumerate(("a.xml", "b.xml"), 1):
        (tmp_path / name).write_text(TEXT.format(run=number))
    (tmp_path / "view.xml").write_text(PART.format(size=80))
    return [str(tmp_path / "a.xml"), str(tmp_path / "b.xml")]


def source(layouts: list[str], *, watched: bool = True) -> LayoutSource:
    return LayoutSource(layouts, open_layout, open_layout(layouts[0]), watched=watched)


def save(path: Path | str, text: str, *, later: int = 1) -> None:
    """Save a file so that its time differs, however coarse the clock of the file system is."""
    path = Path(path)
    before = path.stat().st_mtime_ns if path.exists() else 0
    path.write_text(text)
    os.utime(path, ns=(before + later, before + later))


def looked(found: LayoutSource) -> LayoutSpec | LayoutError | None:
    """What a look brings once what was saved has settled."""
    assert found.check() is None
    return found.check()


def opened(result: LayoutSpec | LayoutError | None) -> LayoutSpec:
    assert isinstance(result, LayoutSpec)
    return result


def refused(result: LayoutSpec | LayoutError | None) -> LayoutError:
    assert isinstance(result, LayoutError)
    return result


def test_nothing_happens_while_nothing_is_saved(layouts: list[str]) -> None:
    found = source(layouts)
    assert [found.check() for _ in range(3)] == [None] * 3


def test_what_is_not_watched_is_not_looked_at(layouts: list[str]) -> None:
    found = source(layouts, watched=False)
    save(layouts[0], TEXT.format(run=7))
    assert looked(found) is None
    assert found.changes
    assert not source(layouts[:1], watched=False).changes
    assert source(layouts[:1]).changes


def test_a_layout_or_its_part_that_is_saved_is_opened_once(layouts: list[str]) -> None:
    found = source(layouts)
    save(layouts[0], TEXT.format(run=7))
    assert opened(looked(found)).run_number == 7
    assert found.check() is None
    save(Path(layouts[0]).with_name("view.xml"), PART.format(size=90))
    assert opened(looked(found)).view.arrangements[0].xsize == 90
    assert found.check() is None


def test_what_is_still_being_written_is_left_until_it_rests(layouts: list[str]) -> None:
    found = source(layouts)
    for run in range(2, 5):
        save(layouts[0], TEXT.format(run=run)[: 20 * run])
        assert found.check() is None
    save(layouts[0], TEXT.format(run=9))
    assert opened(looked(found)).run_number == 9


def test_a_bad_layout_is_said_once_and_the_old_one_stays(layouts: list[str]) -> None:
    found = source(layouts)
    save(layouts[0], TEXT.format(run="x").replace("magellan", " "))
    error = refused(looked(found))
    assert found.check() is None
    assert found.layout.run_number == 1
    assert first_problem(error) == (
        "The layout stays as it was; 2 problems, first: a.xml:1:7: run of <rune> is 'x', "
        "it must be a whole number from 0 to 999999"
    )
    save(layouts[0], TEXT.format(run=3))
    assert opened(looked(found)).run_number == 3


def test_a_part_that_was_missing_is_waited_for(layouts: list[str]) -> None:
    found = source(layouts)
    save(layouts[0], TEXT.format(run=2).replace("view.xml", "other.xml"))
    assert "there is no such file" in str(refused(looked(found)))
    save(Path(layouts[0]).with_name("other.xml"), PART.format(size=70))
    assert opened(looked(found)).view.arrangements[0].xsize == 70


def test_a_file_that_is_taken_away_and_put_back_is_opened_again(layouts: list[str]) -> None:
    found = source(layouts)
    text = Path(layouts[0]).read_text()
    Path(layouts[0]).unlink()
    assert "there is no such file" in str(refused(looked(found)))
    Path(layouts[0]).write_text(text)
    assert opened(looked(found)).run_number == 1


def test_what_is_saved_while_it_is_read_is_read_again(layouts: list[str]) -> None:
    def read(name: str) -> LayoutSpec:
        layout = open_layout(name)
        if layout.run_number == 2:
            save(name, TEXT.format(run=3))
        return layout

    found = LayoutSource(layouts, read, open_layout(layouts[0]), watched=True)
    save(layouts[0], TEXT.format(run=2))
    assert opened(looked(found)).run_number == 2
    assert opened(looked(found)).run_number == 3


def test_an_extension_that_is_saved_runs_anew(tmp_path: Path) -> None:
    program = (Path(__file__).parents[2] / "bad_layouts" / "parts" / "good.py").read_text()
    path = tmp_path / "layout.xml"
    path.write_text(
        '<rune><extension file="good.py"/><robot name="a"/><view xsize="9" ysize="9"/></rune>'
    )
    (tmp_path / "good.py").write_text(program)
    found = source([str(path)])
    before = found.layout.vocabulary.visualizers["visualizeNothing"]
    save(tmp_path / "good.py", program.replace("nothing", "nothin'"))
    after = opened(looked(found)).vocabulary.visualizers["visualizeNothing"]
    assert (before.rule.meaning, after.rule.meaning) == ("nothing", "nothin'")
    assert not (tmp_path / "__pycache__").exists()


def test_the_next_layouts_come_in_turn(layouts: list[str]) -> None:
    found = source(layouts, watched=False)
    assert [opened(found.next()).run_number for _ in range(3)] == [2, 1, 2]
    assert found.layout.run_number == 2


def test_a_next_layout_that_is_bad_is_passed_over_the_next_time(layouts: list[str]) -> None:
    third = Path(layouts[0]).with_name("c.xml")
    third.write_text(TEXT.format(run=3))
    found = LayoutSource([*layouts, str(third)], open_layout, open_layout(layouts[0]), watched=True)
    Path(layouts[1]).write_text("<rune>")
    refused(found.next())
    assert found.layout.run_number == 1
    save(layouts[0], TEXT.format(run=11))  # the one that is open is still the one that is watched
    assert opened(looked(found)).run_number == 11
    refused(found.next())
    assert opened(found.next()).run_number == 3
    save(third, TEXT.format(run=33))
    assert opened(looked(found)).run_number == 33


def test_a_layout_that_fails_in_some_other_way_is_read_again_only_when_it_is_saved_again(
    layouts: list[str],
) -> None:
    reads: list[str] = []

    def read(name: str) -> LayoutSpec:
        reads.append(name)
        raise ZeroDivisionError

    found = LayoutSource(layouts, read, open_layout(layouts[0]), watched=True)
    for count in (1, 2):
        save(layouts[0], TEXT.format(run=count + 7), later=count)
        with pytest.raises(ZeroDivisionError):
            looked(found)
        assert (found.check(), found.check(), found.check()) == (None, None, None)
        assert len(reads) == count


def test_a_layout_that_was_opened_alone_goes_to_the_one_that_it_names_and_back() -> None:
    one, other = "robobot-2003-expanded", "robobot-2003-collapsed"
    both = LayoutSource([one], open_layout, open_layout(one), watched=False)
    assert both.several
    assert [Path(opened(both.next()).path).stem for _ in range(2)] == [other, one]
    assert not LayoutSource(["demo"], open_layout, open_layout("demo"), watched=False).several
