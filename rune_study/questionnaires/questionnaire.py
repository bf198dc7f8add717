"""Questionnaires: their files, and the order in which one person gets the items."""

from __future__ import annotations

from pathlib import Path

from hub.toml_reader import (
    TOP,
    Key,
    Problems,
    choice,
    key,
    keys_of,
    plain_name,
    read_table,
    repeated,
    several,
    text,
    truth,
)
from hub.toml_reader import load as load_toml
from hub.values import dataclass
from rune_study.errors import QuestionnaireError
from rune_study.lots import shuffled
from rune_study.questionnaires.items import (
    KINDS,
    MOST_ITEMS,
    ComparedItem,
    Item,
    Pair,
    keys_of_item,
    pairs_of,
)

SHIPPED = Path(__file__).parent / "files"
"""Folder of the questionnaires that Rune ships."""
_PAIR_QUESTION = "Which of the two contributed more to the workload of the task?"


@dataclass(frozen=True, slots=True, kw_only=True)
class Questionnaire:
    """A questionnaire.

    Attributes:
        name: Its name in the data.
        title: Its title.
        source: Who made it, and where it was published.
        instructions: What people read before the first item; empty: nothing.
        by_lot: Whether each person gets the items in an order by lot.
        private: Whether answers stay out of the data of the study, as consent does.
        pairs: Items that are compared with each other after the last item, by their ids.
        pair_question: The question about each pair.
        items: The items, pairs included.
    """

    name: str = key(plain_name(40), meaning="its name in the data")
    title: str = key(text(100), meaning="its title")
    source: str = key(text(300), "", "who made it, and where it was published")
    instructions: str = key(
        text(4000, any_character=True), "", "what people read before the first item"
    )
    by_lot: bool = key(truth, default=False, meaning="each person gets an order of items by lot")
    private: bool = key(truth, default=False, meaning="answers stay out of the study's data")
    pairs: tuple[str, ...] = key(
        several(plain_name(64), 20), (), "ids of items that are compared in pairs", without="none"
    )
    pair_question: str = key(text(200), _PAIR_QUESTION, "the question about each pair")
    items: tuple[Item, ...] = ()

    def order(self, seed: str) -> list[Item]:
        """The items in the order for one person; pairs are always in an order by lot."""
        own = [item for item in self.items if not isinstance(item, Pair)]
        pairs = [item for item in self.items if isinstance(item, Pair)]
        mixed = shuffled(own, seed, self.name, "items") if self.by_lot else own
        return [*mixed, *shuffled(pairs, seed, self.name, "pairs")]


def shipped() -> list[str]:
    """Names of the questionnaires that Rune ships."""
    return sorted(path.stem for path in SHIPPED.glob("*.toml"))


def find(name: str, folder: Path | None = None) -> Path:
    """The file of a questionnaire: a path, a file in the folder, or one that Rune ships.

    Raises:
        QuestionnaireError: There is none.
    """
    places = [Path(name), SHIPPED / f"{name}.toml"]
    if folder is not None:
        places[:0] = [folder / name, folder / f"{name}.toml"]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        known = ", ".join(shipped())
        raise QuestionnaireError(name, [f"there is no such file; Rune ships {known}"])
    return found


def read(path: Path) -> Questionnaire:
    """Read the file of a questionnaire.

    Raises:
        QuestionnaireError: It has mistakes; the error lists all of them.
    """
    data, problems = load_toml(path, QuestionnaireError)
    own = read_table(keys_of(Questionnaire), data, TOP, problems, tables=["item"])
    items = _items(data.get("item", []), problems)
    by_id = {item.id: item for item in items}
    if len(by_id) < len(items):
        problems.append("two items have the same id; give each its own")
    compared = [by_id[each] for each in own["pairs"] or () if each in by_id]
    if len(compared) != len(own["pairs"] or ()):
        problems.add(TOP, "key 'pairs' names an item that is not in the file", "pairs")
    if problems:
        raise QuestionnaireError(str(path), list(problems))
    pairs = pairs_of(compared, own["pair_question"])
    return Questionnaire(**own, items=(*items, *pairs))


def _items(tables: object, problems: Problems) -> list[Item]:
    if not isinstance(tables, list) or not 1 <= len(tables) <= MOST_ITEMS:
        problems.append(f"write 1 to {MOST_ITEMS} tables [[item]]")
        return []
    found = []
    for count, table in enumerate(tables, 1):
        place = repeated("item", count)
        kind = table.get("kind") if isinstance(table, dict) else None
        if not isinstance(kind, str) or kind not in KINDS:
            read_table({"kind": Key(choice(KINDS))}, {"kind": kind}, place, problems)
            continue
        before = len(problems)
        fields = read_table(keys_of_item(kind), table, place, problems)
        del fields["kind"]
        if len(problems) == before:
            item = KINDS[kind](**fields)
            fault = item.fault() if isinstance(item, ComparedItem) else None
            if fault is not None:
                problems.add(place, f"{place}, key '{fault[0]}': {fault[1]}", fault[0])
            found.append(item)
    return found
