"""`rune shot`: the picture of a layout, drawn without a terminal."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Collection, Mapping

from hub.gcm.mapping import MAP
from rune_tui.compositor.picture import PictureFile
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_link import RobotLink
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase
from rune_tui.view import View

_POLL_S = 0.02
_EXTRA_S = 10.0
"""Longest extra time to watch: a robot that just started has not sent all messages [s]."""


def take(
    layout: LayoutSpec,
    links: Mapping[str, RobotLink],
    *,
    size: tuple[int, int],
    seconds: float,
    offline: bool,
    output: PictureFile,
) -> bool:
    """Watch the robots for a time, then write the console's picture.

    Args:
        layout: The layout.
        links: A link for each robot, not yet started.
        size: Columns and rows of the terminal [cells].
        seconds: Time to watch [s].
        offline: Whether to write the file although no hub answers.
        output: The file to write.

    Returns:
        Whether every robot's hub answered; if not, the file is written only with `offline`.

    Raises:
        PictureFileError: The file cannot be written.
    """
    view = View(layout, pixels_per_cell=output.pixels_per_cell)
    view.resize(*size)
    state = dataclasses.replace(
        ConsoleState.at_start(layout, time.monotonic()),
        robots={name: link.state for name, link in links.items()},
    )
    needs = view.picture_needs(state)
    for name, link in links.items():
        link.want_pictures(needs.get(name, {}))
        link.start()
    try:
        end = time.monotonic() + seconds
        while (now := time.monotonic()) < end or (now < end + _EXTRA_S and _waits(links, needs)):
            for link in links.values():
                for camera, picture in link.state.all_pictures.items():
                    link.shown(picture.number, camera)
            time.sleep(_POLL_S)
        robots = {name: link.state for name, link in links.items()}
        state = dataclasses.replace(state, now=time.monotonic(), robots=robots)
        cells = view.render(state)
    finally:
        for link in links.values():
            link.close()
    answered = all(robot.link.phase is LinkPhase.CONNECTED for robot in robots.values())
    if (answered or offline) and cells is not None:
        output.write(output.draw(cells, view.pictures, view.urgencies))
    return answered


def _waits(links: Mapping[str, RobotLink], pictured: Collection[str]) -> bool:
    """Whether messages of hubs that answer are still missing."""
    robots = [link.state for link in links.values()]
    return any(
        (robot.name in pictured and robot.picture is None)
        or (MAP.name in links[robot.name].spec.messages and robot.map is None)
        for robot in robots
        if robot.link.phase is LinkPhase.CONNECTED
    )
