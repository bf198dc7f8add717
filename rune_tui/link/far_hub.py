"""Finds a hub on another machine: the commands for its shell, and their answer; pure.

They look where `hub.paths.for_hubs` says that hubs of this user are, and leave out those whose
process is gone.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath
from typing import Final

from hub.hub_sockets import NAMED, PREFERRED, folder_name
from hub.plain_text import plain
from rune_tui.errors import TunnelError

SCRIPT: Final = r"""
u=$(id -u)
for d in "$RUNE_RUNTIME_DIR" "$XDG_RUNTIME_DIR/rune" "/run/user/$u/rune" \
    "${TMPDIR:-/tmp}/rune-$u" "/tmp/rune-$u" /run/*/rune; do
  case "$u $d" in "0 /run/"*) ;; *) [ -O "$d" ] || continue ;; esac
  for s in "$d"/*/hub; do
    [ -S "$s" ] && kill -0 "$(cat "${s%hub}pid")" && printf 'hub %s\n' "$s"
  done
done 2>/dev/null
echo end
"""
_HUB: Final = "hub "
_END: Final = "end"
_MOST: Final = 64


def paths_in(answer: str) -> list[str]:
    """The control sockets in an answer of the shell, each once.

    Raises:
        TunnelError: The shell did not run the commands.
    """
    lines = answer.splitlines()
    if _END not in lines:
        text = (
            "the robot runs no commands for this login, so its hub is not found; name its socket "
            "there, such as --hub ipc:///run/user/1000/rune/magellan/hub"
        )
        raise TunnelError(text)
    found = [line.removeprefix(_HUB) for line in lines if line.startswith(_HUB)][:_MOST]
    by_name = {PurePosixPath(path).parent.name: path for path in reversed(found)}
    return [by_name[name] for name in sorted(by_name)]


def chosen(paths: Sequence[str], hub: str) -> str:
    """The path of the hub that is meant, of those that run.

    Args:
        paths: Their control sockets.
        hub: `hub://NAME`, `hub://?NAME` or `hub://`.

    Raises:
        TunnelError: It does not run, or several do and none is named.
    """
    wanted = hub.removeprefix(NAMED)
    name = wanted.removeprefix(PREFERRED)
    by_name = {PurePosixPath(path).parent.name: path for path in paths}
    if name and folder_name(name) in by_name:
        return by_name[folder_name(name)]
    if len(by_name) == 1 and (wanted != name or not name):
        return next(iter(by_name.values()))
    there = plain(", ".join(by_name)) if by_name else "none"
    text = f"no hub {name} runs there as this user; hubs there: {there}"
    if len(by_name) > 1 and (wanted != name or not name):
        text = f"several hubs run there: {there}; choose one with --hub NAME"
    raise TunnelError(text)
