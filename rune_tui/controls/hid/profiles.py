"""Names of the buttons of common gamepads, and mistakes of some descriptors.

Names follow the place, as SDL's do: "a" is the lowest of the four buttons at the right, with any
letter printed on it. Sources: the mappings of SDL and of SDL_GameControllerDB (both zlib licence),
and the drivers hid-sony, hid-playstation, hid-nintendo and hid-dr of Linux.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from hub.values import dataclass

_SONY, _MICROSOFT, _LOGITECH, _NINTENDO = 0x054C, 0x045E, 0x046D, 0x057E
_GOOGLE, _8BITDO, _DRAGONRISE = 0x18D1, 0x2DC8, 0x0079

_DUALSHOCK_3 = (
    "back leftstick rightstick start dpup dpright dpdown dpleft"
    " lefttrigger righttrigger leftshoulder rightshoulder y b a x guide"
)
# 7 and 8 are the triggers, which are axes too.
_DUALSHOCK_4 = "x a b y leftshoulder rightshoulder - - back start leftstick rightstick guide"
# Google's rules for gamepads; the gaps are C, Z and the triggers.
_ANDROID = "a b - x y - leftshoulder rightshoulder - - back start guide leftstick rightstick"
_DIRECT_INPUT = (
    "x a b y leftshoulder rightshoulder lefttrigger righttrigger back start leftstick rightstick"
)
_DRAGONRISE_6 = (
    "y b a x leftshoulder rightshoulder lefttrigger righttrigger back start leftstick rightstick"
)
_SWITCH = (
    "a b x y leftshoulder rightshoulder lefttrigger righttrigger"
    " back start leftstick rightstick guide"
)


def _numbered(roles: str) -> dict[str, str]:
    """The roles of the buttons from 1 on; "-" for one that has only its number."""
    return {f"button {number}": role for number, role in enumerate(roles.split(), 1) if role != "-"}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Profile:
    """Roles by usage for devices of one maker; for all of them if no ids are given."""

    vid: int
    pids: frozenset[int]
    roles: Mapping[str, str] = field(default_factory=dict)


_PROFILES = (
    _Profile(vid=_SONY, pids=frozenset({0x0268}), roles=_numbered(_DUALSHOCK_3)),
    _Profile(
        vid=_SONY,
        pids=frozenset({0x05C4, 0x09CC, 0x0BA0, 0x0CE6, 0x0DF2}),
        roles=_numbered(_DUALSHOCK_4),
    ),
    # Elite 2 and model 1708 have "back" beside the numbered buttons; 1708 "home" too.
    _Profile(
        vid=_MICROSOFT,
        pids=frozenset({0x0B05}),
        roles=_numbered(_ANDROID) | {"button 11": "button11"},
    ),
    _Profile(
        vid=_MICROSOFT,
        pids=frozenset({0x02FD}),
        roles=_numbered(_ANDROID) | {"button 11": "button11", "button 13": "button13"},
    ),
    _Profile(vid=_MICROSOFT, pids=frozenset(), roles=_numbered(_ANDROID)),
    _Profile(vid=_GOOGLE, pids=frozenset({0x9400}), roles=_numbered(_ANDROID)),
    _Profile(
        vid=_8BITDO,
        pids=frozenset(),
        roles=_numbered(_ANDROID)
        | {"button 1": "b", "button 2": "a", "button 4": "y", "button 5": "x"}
        | {"button 3": "guide", "button 13": "button13"},
    ),
    _Profile(
        vid=_LOGITECH,
        pids=frozenset({0xC216, 0xC218, 0xC219}),  # F310 and Dual Action, F510, F710
        roles=_numbered(_DIRECT_INPUT),
    ),
    _Profile(vid=_NINTENDO, pids=frozenset({0x2009}), roles=_numbered(_SWITCH)),
    # The bytes that are called X, X, X, X, Y hold three constants, X and Y; those that are called
    # X, Y, Z, Z, Rz hold a constant in the third place.
    _Profile(vid=_DRAGONRISE, pids=frozenset({0x0011}), roles={"x#4": "leftx"}),
    _Profile(
        vid=_DRAGONRISE,
        pids=frozenset({0x0006}),
        roles=_numbered(_DRAGONRISE_6) | {"z#2": "rightx"},
    ),
)


def find_profile(vid: int, pid: int, *, gamepad: bool) -> Mapping[str, str]:
    """Known roles of a device, by usage; `gamepad` for one with Android's usages."""
    for profile in _PROFILES:
        if profile.vid == vid and (pid in profile.pids or not profile.pids):
            return profile.roles
    return _numbered(_ANDROID) if gamepad else {}
