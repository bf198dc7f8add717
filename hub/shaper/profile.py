"""Profiles of links: delay, jitter, loss, rate and blackouts, read from TOML files.

A profile is a file in `profiles/`, or one of the user's own. All mistakes of a file are reported
together.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import LinkProfileError
from hub.nearest import did_you_mean
from hub.toml_reader import key, number, numbers, text
from hub.values import dataclass

SHIPPED = Path(__file__).parent / "profiles"
"""Folder of the profiles that come with the hub."""
LONGEST_S = 3600.0
"""Longest gap, blackout or burst [s]."""
PACKET_BYTES = 1500
"""A full packet with its headers [bytes]."""
_SHORTEST_SLOT_S, _LONGEST_SLOT_S = 0.001, 0.05
_SHORTEST_S = 0.01
_LEAST_QUEUE = 16_384
_QUEUE_S = 0.5


def _milliseconds(high: float) -> toml.Within:
    within = number(0.0, high)
    return toml.Within(lambda value: within(value) / 1e3, within.allowed)


def _kilobits(low: float, high: float) -> toml.Within:
    within = number(low, high)
    return toml.Within(lambda value: within(value) * 1e3, within.allowed)


_SPAN = numbers(2, _SHORTEST_S, LONGEST_S)


def _span(value: object) -> tuple[float, float]:
    """The shortest and the longest of a time [s]."""
    low, high = _SPAN(value)
    if low > high:
        reason = f"{toml.shorten(value)} is not [SHORTEST, LONGEST]"
        raise toml.RefusedError(reason)
    return low, high


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectionSpec:
    """One direction of a link.

    Attributes:
        delay: Mean time from the end of sending to the arrival [s].
        jitter: Standard deviation of that time [s].
        loss: Part of the time in which packets are lost, 0 to 0.9.
        burst: Mean length of a loss, in full packets.
        rate: [bit/s]
        queue: Bytes that wait to be sent before the link takes no more; 0: half a second's.
    """

    delay: float = key(_milliseconds(60_000.0), 0.0, "mean delay [ms]", at="delay_ms")
    jitter: float = key(
        _milliseconds(60_000.0), 0.0, "standard deviation of the delay [ms]", at="jitter_ms"
    )
    loss: float = key(number(0.0, 0.9), 0.0, "part of the time in which packets are lost")
    burst: float = key(number(1.0, 1000.0), 1.0, "mean number of full packets lost in a row")
    rate: float = key(_kilobits(1.0, 1e6), 1e8, "rate [kbit/s]", at="rate_kbit", without="100000")
    queue: int = key(
        toml.whole_number(0, 100_000_000),
        0,
        "bytes that wait before the link takes no more",
        at="queue_bytes",
        without="half a second's",
    )

    @property
    def room(self) -> int:
        """Bytes that may wait to be sent."""
        return self.queue or max(_LEAST_QUEUE, int(_QUEUE_S * self.rate / 8.0))

    @property
    def slot(self) -> float:
        """Shortest time of a loss: that of a full packet, within 1 to 50 ms [s]."""
        return min(_LONGEST_SLOT_S, max(_SHORTEST_SLOT_S, PACKET_BYTES * 8.0 / self.rate))


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodesSpec:
    """Times that come again: blackouts of both directions, or bursts of a higher rate.

    Attributes:
        gap: Shortest and longest time between two [s].
        length: Shortest and longest of them [s].
        rate: During a burst [bit/s]; blackouts have none.
    """

    gap: tuple[float, float] = key(
        _span, meaning="[SHORTEST, LONGEST] time between two [s]", at="gap_s"
    )
    length: tuple[float, float] = key(
        _span, meaning="[SHORTEST, LONGEST] of them [s]", at="length_s"
    )
    rate: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstsSpec(EpisodesSpec):
    """Bursts of a higher rate."""

    rate: float = key(_kilobits(1.0, 1e6), meaning="rate in a burst [kbit/s]", at="rate_kbit")


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkProfile:
    """How a link behaves.

    Attributes:
        name: Of the file, without its end.
        purpose: What it stands for, for people.
        picture_rate: Most pictures per second that cameras give [1/s]; 0: no limit.
        up: From the console to the hub.
        down: From the hub to the console.
        blackouts: Times in which all packets are lost; None: there are none.
        bursts: Times with another rate; None: there are none.
        digest: SHA-256 of the file.
    """

    name: str = ""
    purpose: str = key(text(200), "", "what it stands for")
    picture_rate: float = key(
        number(0.0, 1000.0), 0.0, "most pictures per second; 0: no limit", at="picture_rate_hz"
    )
    up: DirectionSpec = DirectionSpec()
    down: DirectionSpec = DirectionSpec()
    blackouts: EpisodesSpec | None = None
    bursts: EpisodesSpec | None = None
    digest: str = ""

    @property
    def round_trip(self) -> float:
        """Mean time there and back, without sending [s]."""
        return self.up.delay + self.down.delay

    @property
    def jitter(self) -> float:
        """Standard deviation of the time there and back [s]."""
        return math.hypot(self.up.jitter, self.down.jitter)


def shipped_profiles() -> tuple[str, ...]:
    """Names of the profiles that come with the hub."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def profile_path(name_or_path: str) -> Path:
    """The file of a shipped profile, or the path as it is.

    Raises:
        LinkProfileError: It is neither.
    """
    known = shipped_profiles()
    if name_or_path in known:
        return SHIPPED / f"{name_or_path}.toml"
    path = Path(name_or_path)
    if path.suffix != ".toml":
        hint = did_you_mean(name_or_path, known)
        text = f"is no profile of a link{hint}; there are {', '.join(known)}, or name a .toml file"
        raise LinkProfileError(name_or_path, [text])
    return path


def load_profile(name_or_path: str) -> LinkProfile:
    """Read and check a shipped profile, or a file.

    Raises:
        LinkProfileError: There is none, or it has mistakes, which are all listed.
    """
    path = profile_path(name_or_path)
    data, problems = toml.load(path, LinkProfileError)
    made = check_profile(data, problems)
    if problems:
        raise LinkProfileError(str(path), problems)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return dataclasses.replace(made, name=path.stem[:64], digest=digest)


def check_profile(data: Mapping[str, Any], problems: toml.Problems) -> LinkProfile:
    """The profile in the content of a file; mistakes are added to `problems`."""
    own, one_way = toml.keys_of(LinkProfile), toml.keys_of(DirectionSpec)
    tables = {
        "up": one_way,
        "down": one_way,
        "blackouts": toml.keys_of(EpisodesSpec),
        "bursts": toml.keys_of(BurstsSpec),
    }
    fields = toml.read_table({**own, **one_way}, data, toml.TOP, problems, tables=tables)
    both = {key.field: fields.pop(key.field) for key in one_way.values()}
    read = {
        name: toml.read_table(keys, data[name], f"[{name}]", problems)
        for name, keys in tables.items()
        if name in data
    }
    if problems:
        return LinkProfile()
    for name in ("up", "down"):
        given = {key.field for word, key in one_way.items() if word in data.get(name, {})}
        fields[name] = DirectionSpec(**both | {each: read[name][each] for each in given})
        _check_direction(fields[name], name, problems)
    kinds = {"blackouts": EpisodesSpec, "bursts": BurstsSpec}
    fields |= {name: kind(**read[name]) for name, kind in kinds.items() if name in read}
    return LinkProfile(**fields)


def _check_direction(spec: DirectionSpec, name: str, problems: toml.Problems) -> None:
    """What only fits together with other keys."""
    if spec.jitter > 2.0 * spec.delay:
        problems.add(
            toml.TOP,
            f"jitter_ms = {spec.jitter * 1e3:g} ({name}) is more than twice delay_ms = "
            f"{spec.delay * 1e3:g}",
            "jitter_ms",
        )
    least = spec.loss / (1.0 - spec.loss)
    if spec.burst < least:
        text = f"burst = {spec.burst:g} ({name}) is too short for loss = {spec.loss:g}"
        problems.add(
            toml.TOP, f"{text}; write at least {math.ceil(100.0 * least) / 100.0:g}", "burst"
        )
