"""The limit that a link shaper sets to the picture rate of cameras; pure."""

from __future__ import annotations

from hub.gcm.shaper import SHAPER_STATE, ShaperState


class PictureRateLimit:
    """The lowest picture rate of the link shapers that are at this hub now."""

    def __init__(self) -> None:
        self._heard: dict[str, tuple[float, float]] = {}

    def hear(self, state: ShaperState, now: float) -> None:
        """Note the state of a link shaper, at a time [s]."""
        self._heard = {
            address: known
            for address, known in self._heard.items()
            if now - known[1] < SHAPER_STATE.lifespan_s
        }
        if state.picture_rate > 0.0:
            self._heard[state.address] = (state.picture_rate, now)
        else:
            self._heard.pop(state.address, None)

    def at(self, now: float) -> float:
        """Most pictures per second of each camera at a time [1/s]; 0: no limit."""
        rates = (
            rate for rate, heard in self._heard.values() if now - heard < SHAPER_STATE.lifespan_s
        )
        return min(rates, default=0.0)
