"""A recording has the links of robots, whatever their numbers and lacks."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.files.frame_log import link_record
from rune_tui.model.own_records import RUNE_LINK
from rune_tui.model.robot_state import Lack, LackKind, LinkPhase, LinkState, RobotState
from rune_tui.replay.console_log import link_state

UNSIGNED = st.integers(0, 2**32 - 1)
TEXT = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=20)
LINKS = st.builds(
    LinkState,
    phase=st.sampled_from(LinkPhase),
    since=st.floats(allow_nan=False),
    endpoint=TEXT,
    detail=TEXT,
    may_command=st.booleans(),
    round_trip=st.floats(allow_nan=False),
    bytes_per_s=st.floats(allow_nan=False),
    messages_per_s=st.floats(allow_nan=False),
    missed=UNSIGNED,
    lacking=st.dictionaries(TEXT, st.builds(Lack, kind=st.sampled_from(LackKind), why=TEXT)),
    unfit=st.dictionaries(TEXT, TEXT),
    number=UNSIGNED,
    refusal_count=UNSIGNED,
)


@given(LINKS)
def test_the_state_of_a_link_comes_back_as_it_was(link: LinkState) -> None:
    record = link_record(RobotState(name="blimp", link=link), "dirigible", 7)
    payload = b"".join(bytes(part) for part in RUNE_LINK.encode(record))
    assert link_state(RUNE_LINK.decode(payload)) == link
