"""Reports what a link shaper does: on the hub that it shapes, and as lines of JSON."""

from __future__ import annotations

import json
import logging
import math
import threading
import time
from collections.abc import Callable, Sequence
from typing import TextIO

from hub.errors import NotAllowedError
from hub.gcm.shaper import SHAPER_STATE, ShapedDirection, ShaperState
from hub.ipc.client import Client
from hub.shaper.conditions import DirectionConditions
from hub.shaper.model import DirectionCounts
from hub.shaper.profile import LinkProfile
from hub.shaper.relay import Relay

_logger = logging.getLogger(__name__)

_LOOK_S = 0.05
"""Time between two looks at blackouts [s]."""
_PERIOD_S = 1.0 / SHAPER_STATE.rate_hz


class Reporter:
    """A thread of its own with a client of the hub, beside the link and not through it."""

    def __init__(
        self,
        client: Client,
        relay: Relay,
        profile: LinkProfile,
        seed: int,
        *,
        outputs: Sequence[TextIO] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare.

        Args:
            client: Connected to the hub; from `start` on the thread's own.
            relay: What is reported.
            profile: Its profile.
            seed: Its seed.
            outputs: Get a line for each state.
            clock: Monotonic time, the relay's [s].
        """
        self._client, self._relay, self._profile, self._seed = client, relay, profile, seed
        self._clock, self._outputs = clock, list(outputs)
        self._publishes = _may_publish(client)
        self._conditions = DirectionConditions(profile, seed, up=True)  # the relay has its own
        self._before = (DirectionCounts(), DirectionCounts())
        self._blackout, self._due = False, 0.0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="reporter", daemon=True)

    def start(self) -> None:
        """Begin to report."""
        self._thread.start()

    def close(self) -> None:
        """End; the client is closed."""
        self._ending.set()
        self._thread.join()

    def _serve(self) -> None:
        self._client.every(_LOOK_S, self._look)
        while not self._ending.is_set():
            self._client.listen(_LOOK_S)
        self._client.close()

    def _look(self) -> None:
        """Report each second, and at once when a blackout begins or ends."""
        now = self._clock()
        blackout = self._conditions.blackout(now - self._relay.started)
        if blackout == self._blackout and now < self._due:
            return
        self._blackout, self._due = blackout, now + _PERIOD_S
        state = self._state(now)
        if self._publishes:
            self._client.publish(SHAPER_STATE, state, measured=now)
        line = json.dumps(line_of(state)) + "\n"
        for output in tuple(self._outputs):
            try:
                output.write(line)
                output.flush()
            except (OSError, ValueError) as error:  # a full disk, or a reader that ended
                self._outputs.remove(output)
                _logger.warning("states are no longer written to %s: %s", output.name, error)

    def _state(self, now: float) -> ShaperState:
        counts = (self._relay.model.up.counts, self._relay.model.down.counts)
        up, down = (
            _direction(*each) for each in zip(counts, self._before, self._relay.held(), strict=True)
        )
        self._before = counts
        return ShaperState(
            profile=self._profile.name,
            digest=self._profile.digest,
            seed=self._seed,
            address=self._relay.address,
            elapsed=now - self._relay.started,
            connections=self._relay.connections,
            blackout=int(self._blackout),
            picture_rate=self._profile.picture_rate,
            up=up,
            down=down,
        )


def _may_publish(client: Client) -> bool:
    """Whether the client's key lets it publish states."""
    try:
        client.demand_right(SHAPER_STATE)
    except NotAllowedError:
        return False
    return True


def line_of(state: ShaperState) -> dict[str, object]:
    """A state for programs."""
    ways = {
        name: {
            "packets": way.packets,
            "bytes": way.size,
            "lost": way.lost,
            "held": way.held,
            "delay_ms": None if math.isnan(way.delay) else round(way.delay * 1e3, 3),
        }
        for name, way in (("up", state.up), ("down", state.down))
    }
    return {
        "event": "state",
        "elapsed_s": round(state.elapsed, 3),
        "connections": state.connections,
        "blackout": bool(state.blackout),
        **ways,
    }


def _direction(counts: DirectionCounts, before: DirectionCounts, held: int) -> ShapedDirection:
    delivered = counts.delivered - before.delivered
    mean = (counts.delay - before.delay) / delivered if delivered > 0 else math.nan
    return ShapedDirection(
        packets=counts.packets, size=counts.bytes, lost=counts.lost, held=held, delay=mean
    )
