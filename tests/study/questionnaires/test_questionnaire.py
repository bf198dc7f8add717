"""Files of questionnaires: the shipped ones are right, and mistakes are all listed."""

from __future__ import annotations

from pathlib import Path

import pytest

from rune_study.errors import QuestionnaireError
from rune_study.questionnaires.items import Pair, Scale
from rune_study.questionnaires.questionnaire import find, read, shipped


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_questionnaire_has_its_file_name(name: str) -> None:
    assert read(find(name)).name == name


def test_the_load_index_has_its_21_marks_and_compares_each_pair_once() -> None:
    index = read(find("nasa-tlx"))
    scales = [item for item in index.items if isinstance(item, Scale)]
    pairs = [item for item in index.items if isinstance(item, Pair)]
    assert [(scale.marks, scale.value(0), scale.value(20)) for scale in scales] == [
        (21, 0, 100)
    ] * 6
    assert len({frozenset((pair.first[0], pair.second[0])) for pair in pairs}) == len(pairs) == 15
    performance = next(scale for scale in scales if scale.id == "performance")
    assert (performance.low, performance.high) == ("Perfect", "Failure")


def test_the_order_of_pairs_is_that_of_the_person() -> None:
    index = read(find("nasa-tlx"))
    first, again, other = (index.order(seed) for seed in ("p01", "p01", "p02"))
    assert first == again != other
    assert set(first) == set(other)
    assert [item.id for item in first[:6]] == [item.id for item in index.items[:6]]


def test_all_mistakes_are_listed_with_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(
        'name = "own"\ntitel = "Own"\n\n[[item]]\nid = "a"\nkind = "scal"\ntext = "?"\n\n'
        '[[item]]\nid = "b"\nkind = "scale"\ntext = "?"\nlow = "no"\nmarks = 1\n'
    )
    with pytest.raises(QuestionnaireError) as caught:
        read(path)
    text = str(caught.value)
    assert "line 2: top of the file: unknown key 'titel'; did you mean 'title'?" in text
    assert "key 'title' is missing" in text
    assert "line 6: [[item]] 1, key 'kind': 'scal' is none of" in text
    assert "line 14: [[item]] 2, key 'marks': 1 is not between 2 and 101" in text
    assert "[[item]] 2: key 'high' is missing" in text


def test_an_unknown_name_lists_what_is_shipped() -> None:
    with pytest.raises(QuestionnaireError, match="Rune ships consent, demographics, nasa-tlx"):
        find("tlx")
