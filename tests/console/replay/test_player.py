"""A replay shows the same frame whatever way led to it."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from rune_tui.compositor.cells import Cells
from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.drawing import FrameCheck, FrameDrawer
from rune_tui.replay.player import Knowledge, Player
from tests.console.replay.logged_session import HERTZ, logged_session
from tests.system.harness import in_soak

SECONDS = 40
SECOND = 1_000_000_000


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return logged_session(tmp_path_factory.mktemp("session"), SECONDS)


@pytest.fixture
def player(session: Path) -> Iterator[Player]:
    with closing(Player(partial(ConsoleLog, session))) as player:
        yield player


@pytest.fixture(scope="module")
def drawn(session: Path) -> dict[int, int]:
    """Checksum of what is shown at each time, drawn from the beginning."""
    drawer, found = FrameDrawer(), {}
    with closing(ConsoleLog(session)) as log:
        for frame in log.frames(log.start - 1, log.end):
            drawer.draw(frame)
            assert drawer.cells is not None
            found[frame.stamp] = drawer.cells.checksum
            if frame.checksum is not None:
                assert drawer.cells.checksum == frame.checksum
    assert len(found) == SECONDS * HERTZ
    assert len(set(found.values())) > SECONDS
    return found


def shown(player: Player) -> int:
    cells = player.drawer.cells
    assert cells is not None
    return cells.checksum


def different(cells: Cells | None, others: Cells | None) -> int:
    """Number of half cells whose pixels differ."""
    assert cells is not None
    assert others is not None
    return int((cells.pixels != others.pixels).any(axis=-1).sum())


def ticking(steps: float) -> Callable[[], float]:
    """A clock that goes on at each look."""
    times = itertools.count()
    return lambda: steps * next(times)


@pytest.mark.parametrize("seed", [2, *in_soak(1)])
def test_a_hundred_jumps_show_what_was_drawn(
    player: Player, drawn: dict[int, int], seed: int
) -> None:
    chance = random.Random(seed)
    for stamp in chance.choices(list(drawn), k=100):
        player.seek(stamp + chance.randrange(SECOND // HERTZ), whole=True)
        assert shown(player) == drawn[player.position]


def test_a_jump_into_the_unknown_is_exact_once_the_recording_is_prepared(
    player: Player, drawn: dict[int, int]
) -> None:
    player.seek(player.source.end)
    assert player.knows is Knowledge.SECONDS
    while player.prepare(ticking(0.001), 0.05):
        pass
    assert player.knows is Knowledge.ALL
    assert shown(player) == drawn[player.position]
    player.seek(player.source.start + 23 * SECOND)
    assert player.knows is Knowledge.ALL
    assert shown(player) == drawn[player.position]


@pytest.mark.soak
def test_a_jump_in_a_long_recording_fills_at_once_and_is_exact_later(tmp_path: Path) -> None:
    opened = partial(ConsoleLog, logged_session(tmp_path, 150, hertz=2))
    expected = FrameDrawer()
    with closing(opened()) as log:
        for frame in log.frames(log.start - 1, log.end):
            expected.draw(frame)
    with closing(Player(opened)) as player:
        cells = player.seek(player.source.end)
        assert cells is not None
        assert player.knows is Knowledge.SECONDS
        short = different(cells, expected.cells)
        while player.knows is Knowledge.SECONDS:
            player.prepare(ticking(0.001), 0.05)
        assert player.ready < 0.1
        assert different(player.drawer.cells, expected.cells) < short / 2
        while player.prepare(ticking(0.001), 0.05):
            pass
        assert player.prepare(ticking(0.001), 0.05) is False
        assert player.knows is Knowledge.ALL
        assert player.ready == 1.0
        assert different(player.drawer.cells, expected.cells) == 0


@pytest.mark.parametrize("seed", [3, 4])
def test_jumps_on_a_fresh_file_are_exact_when_they_settle(
    session: Path, drawn: dict[int, int], seed: int
) -> None:
    chance = random.Random(seed)
    with closing(Player(partial(ConsoleLog, session))) as player:
        for _ in range(50):
            player.seek(chance.choice(list(drawn)) + chance.randrange(SECOND // HERTZ))
            while player.knows is not Knowledge.ALL:
                player.prepare(ticking(0.001), 0.02)
            assert shown(player) == drawn[player.position]
            assert player.drawer.check in (FrameCheck.SAME, FrameCheck.UNKNOWN)


def test_a_high_rate_is_kept_by_fewer_frames_and_exact_in_a_pause(
    player: Player, drawn: dict[int, int]
) -> None:
    player.seek(player.source.start)
    player.playing, player.rate = True, 100.0
    clock = ticking(0.001)  # 25 frames a turn, of 33 that the rate asks for
    for tick in range(9):
        player.tick(tick / 30.0, clock, 0.025)
    assert player.position > player.source.start + 20 * SECOND
    assert player.knows is Knowledge.SOME
    while player.playing:
        tick += 1
        player.tick(tick / 30.0, clock, 0.025)
    assert player.position == player.source.end
    while player.knows is not Knowledge.ALL:
        player.prepare(clock, 0.05)
    assert shown(player) == drawn[player.position]


def test_another_size_is_said(player: Player) -> None:
    player.seek(player.source.start + SECOND)
    assert player.drawer.check is FrameCheck.SAME
    player.resize((50, 18))
    assert player.drawer.check is FrameCheck.OTHER_SIZE


def test_steps_go_on_and_back_by_one_frame(player: Player, drawn: dict[int, int]) -> None:
    stamps = list(drawn)
    player.seek(stamps[200], whole=True)
    for _ in range(30):
        player.step(1)
    assert player.position == stamps[230]
    for _ in range(60):
        player.step(-1)
        assert shown(player) == drawn[player.position]
    assert player.position == stamps[170]
    player.seek(stamps[0])
    assert player.step(-1) is None


@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_a_rate_takes_its_share_of_the_time(
    player: Player, drawn: dict[int, int], rate: float
) -> None:
    player.seek(player.source.start)
    player.playing, player.rate = True, rate
    ticks = 0
    while player.playing:
        player.tick(ticks / 30.0)
        assert shown(player) == drawn[player.position]
        ticks += 1
    assert ticks / 30.0 == pytest.approx(SECONDS / rate, rel=0.03)
    assert player.position == player.source.end


def test_it_plays_back_to_the_start(player: Player, drawn: dict[int, int]) -> None:
    player.seek(player.source.start + 5 * SECOND, whole=True)
    player.turn()
    player.playing = True
    seen = []
    for tick in range(200):
        player.tick(tick / 30.0)
        seen.append(player.position)
        assert shown(player) == drawn[player.position]
    assert seen == sorted(seen, reverse=True)
    assert player.position == player.source.start
    assert not player.playing


def test_a_loop_begins_again(player: Player) -> None:
    player.seek(player.source.end - SECOND)
    player.playing = player.loop = True
    places = []
    for tick in range(60):
        player.tick(tick / 30.0)
        places.append(player.position)
    assert player.playing
    assert min(places) < player.source.start + SECOND < player.source.end - SECOND < max(places)


def test_the_reached_rate_is_that_of_a_busy_machine(player: Player) -> None:
    player.seek(player.source.start)
    player.playing, player.rate = True, 100.0
    clock = ticking(1.0)  # each look at the clock ends the turn
    for tick in range(45):
        player.tick(tick / 30.0, clock, 0.5)
    assert player.reached < 10.0
