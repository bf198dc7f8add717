"""The mapping process: makes the map, answers requests for it, and keeps the mission."""

from __future__ import annotations

import dataclasses
import functools
import logging
import math
import sys
import time

import numpy as np

from hub.bucket import Bucket
from hub.errors import HandlerFailedError, MapFileError, MissionError, RobotFileError
from hub.gcm import imu, mapping, navigation, ranges
from hub.gcm.beam_scans import LARGEST_TILT, ScanReader
from hub.gcm.capability import Abilities, Capability
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.occupancy_map import OccupancyMap
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.missions import storage
from hub.missions.folder import MissionFolder
from hub.missions.keeper import MissionKeeper, MissionLimits
from hub.modules.mapping.grid import LOADED, MAX_EDGE_CELLS, OccupancyGrid
from hub.modules.mapping.mission_desk import MissionDesk
from hub.modules.mapping.painted_map import PaintedMap
from hub.modules.mapping.scans import ScanSelector
from hub.paths import for_maps, for_missions
from hub.robots.description import RobotDescription
from hub.robots.registry import kind_of
from hub.runtime import run_module

_logger = logging.getLogger(__name__)

SAVE_S = 10.0
"""Time between two saves of a map that changes [s]."""
MARKED_S = 0.5
"""Delay from a mark to a save of the map [s]; several marks at once need one save."""
ORDERS_PER_S, ORDERS_AT_ONCE = 0.2, 20.0
"""Largest rate of orders to save, load or clear maps, and their largest burst [1/s]."""
_UPDATE_S = 0.25
_OWN_S = 0.2
"""Time between two looks at the map that the robot makes itself [s]."""
_REST = 20.0
"""After a mission could not be resumed, mapping waits this multiple of the time that it took."""


class Mapping:
    """Connects the map and the mission with the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        """Resume the running mission, subscribe, and answer requests."""
        self._client = client
        self._robot = robot
        self._reader = ScanReader(robot.body)
        beams = self._reader.beams
        self._grid = OccupancyGrid(robot.map_resolution, robot.map_size, beams)
        self._scans = ScanSelector(beams)
        self._tilted = 0
        steep = int((np.abs(beams.elevation) > LARGEST_TILT).sum())
        if steep:
            text = "%d of %d range beams look up or down: the map takes none of them"
            _logger.info(text, steep, len(beams.elevation))
        self._stamp = 0.0
        self._changed = False
        self._saved = -math.inf
        self._open_again = -math.inf
        self._painted: PaintedMap | None = None
        self._orders = Bucket(ORDERS_PER_S, ORDERS_AT_ONCE)
        self._keeper = MissionKeeper(
            MissionFolder(for_missions(robot.mission_folder), robot.name),
            MissionLimits(
                largest_mb=robot.mission_largest_mb, least_free_mb=robot.mission_least_free_mb
            ),
        )
        self._open()
        self._desk = MissionDesk(
            client,
            self._keeper,
            robot,
            begun=self._start_map,
            marked=self._marked,
            ending=self._save,
        )
        client.subscribe(navigation.ROBOT_STATE, self._state)
        own = kind_of(robot).open_map(robot)
        self._painted = PaintedMap(own, self._grid) if own is not None else None
        client.subscribe(imu.IMU, self._attitude)
        client.subscribe(ranges.RANGES, self._ranges)
        if self._painted is not None:
            client.every(_OWN_S, functools.partial(self._follow_own, self._painted))
            client.define(DIAGNOSTICS)
            period = 1.0 / DIAGNOSTICS.rate_hz
            client.every(period, functools.partial(self._publish_problems, self._painted))
        client.respond(mapping.MAP_REQUEST, mapping.MAP, self._map)
        client.respond(mapping.MAP_COMMAND, COMMON_RESULT, self._command)
        client.every(_UPDATE_S, self._update)

    def finish(self) -> None:
        """Save the rest, and log what was left out."""
        self._save()
        self._keeper.close()
        if self._painted is not None:
            self._painted.close()
        if self._tilted:
            _logger.warning("%d scans were made while the robot was tilted", self._tilted)
        if self._grid.outside:
            _logger.warning("%d scans were made outside of the map", self._grid.outside)

    def _open(self) -> None:
        """Resume the mission that ran when this robot's mapping ended."""
        begin = time.monotonic()
        kept = self._keeper.open()
        now = time.monotonic()
        self._open_again = now + _REST * (now - begin)
        if kept is None:
            return
        lost = self._grid.restore(kept)
        self._stamp = time.time()
        if lost:
            _logger.warning("%d cells of the saved map lie outside of this robot's map", lost)
        book = self._keeper.book
        _logger.info("mission %s goes on with %d marks", book.name, len(book.points.points))

    def _update(self) -> None:
        """Save the map when it is due."""
        unknown = not self._keeper.opened and self._keeper.book.begun is None
        if unknown and time.monotonic() >= self._open_again:
            self._open()
        if self._changed and time.monotonic() - self._saved >= SAVE_S:
            self._save()

    def _save(self) -> None:
        """Save the map now."""
        self._changed = False
        self._saved = time.monotonic()
        if self._keeper.book.running:
            self._keeper.save_map(self._grid.kept())

    def _marked(self, _point: mapping.InterestPoint) -> None:
        """Schedule a save of the map after a mark."""
        self._changed = True
        self._saved = min(self._saved, time.monotonic() - SAVE_S + MARKED_S)

    def _state(self, state: navigation.RobotState, reception: MessageInfo) -> None:
        if self._keeper.in_frame(state.frame, self._grid.kept):
            _logger.warning(
                "the robot has lost its place: sheet %d begins", self._keeper.book.sheet
            )
            self._start_map()
            self._desk.publish()
        self._keeper.trace(state.x, state.y, state.theta)
        self._reader.moved(state, reception.measured)

    def _attitude(self, value: imu.Imu, reception: MessageInfo) -> None:
        self._reader.tilted(value, reception.measured)

    def _ranges(self, readings: ranges.RangeReadings, reception: MessageInfo) -> None:
        if self._painted is not None and self._painted.counts:
            return
        scan = self._reader.read(readings, reception.measured)
        if self._reader.tilt:
            self._tilted += 1
            if self._tilted == 1:
                _logger.warning("the robot is tilted: its scans are left out of the map")
        evidence = self._scans.evidence(scan) if scan and not scan.tilted else None
        if scan is None or evidence is None:
            return
        if self._grid.add(scan.pose, evidence):
            self._stamp = time.time()
            self._changed = True
        elif self._grid.outside == 1:
            _logger.warning("the robot has left the map, which ends %.1f m away", -self._grid.low)

    def _follow_own(self, painted: PaintedMap) -> None:
        """Take the map that the robot makes itself in the place of the grid's."""
        if painted.follow(time.monotonic()):
            self._stamp = time.time()
            self._changed = True

    def _publish_problems(self, painted: PaintedMap) -> None:
        self._client.publish(DIAGNOSTICS, painted.problems())

    def _map(self, request: mapping.MapRequest) -> mapping.Map:
        picture: OccupancyMap | None
        if math.isnan(request.x):
            picture = self._grid.whole()
        else:
            picture = self._grid.window(request.x, request.y, request.width, request.height)
        if picture is None:
            text = (
                f"no part of the map is {request.width:g} m by {request.height:g} m around"
                f" ({request.x:g}, {request.y:g}); x=nan asks for all that is known"
            )
            raise HandlerFailedError(text)
        return picture.message(self._stamp)

    def _command(self, command: mapping.MapCommand) -> CommonResult:
        try:
            text = self._carry_out(command)
        except MapFileError as error:
            _logger.warning("%s", error)
            return CommonResult(done=0, text=str(error))
        _logger.info("%s", text)
        return CommonResult(done=1, text=text)

    def _carry_out(self, command: mapping.MapCommand) -> str:
        """Carry out an order; returns the result, for people.

        Raises:
            MapFileError: The order failed; nothing has changed.
        """
        if not self._orders.take(1.0, time.monotonic()):
            text = "too many orders to save, load or clear maps; wait some seconds and try again"
            raise MapFileError(text)
        if command.order is mapping.MapOrder.CLEAR:
            return self._clear()
        folder = for_maps(self._robot.map_folder)
        name = storage.checked_name(command.name or default_name(self._robot))
        if command.order is mapping.MapOrder.SAVE:
            points = self._keeper.points.points
            path = storage.save(folder, name, self._grid.whole(), points)
            return f"map and {len(points)} points are saved as {path}"
        picture, points = storage.load(folder, name)
        return self._load(picture, points, f"map {name} of {folder}")

    def _clear(self) -> str:
        """Begin a new sheet; the marks stay."""
        self._save()
        self._keeper.begin_sheet("the map was cleared", carries=True)
        self._start_map()
        self._desk.publish()
        return f"the map is empty; {len(self._keeper.points.points)} points are kept"

    def _load(
        self, picture: OccupancyMap, points: tuple[mapping.InterestPoint, ...], subject: str
    ) -> str:
        """Begin a new sheet with the map and points of a file; the old marks stay."""
        self._save()
        self._keeper.begin_sheet(f"{subject} was loaded")
        self._start_map()
        lost = self._grid.paint(picture, LOADED)
        try:
            for point in points:
                self._keeper.mark(dataclasses.replace(point, number=0, version=0), point.by)
        except MissionError as error:
            raise MapFileError(str(error)) from error
        self._save()
        self._desk.publish()
        outside = f"; {lost} cells lie outside of this robot's map" if lost else ""
        return f"{subject} and {len(points)} points are loaded{outside}"

    def _start_map(self) -> None:
        """Clear the map for a new mission or a new sheet."""
        self._grid.clear()
        self._scans = ScanSelector(self._reader.beams)
        self._reader.restart()
        self._changed = True
        if self._painted is not None:
            self._painted.paint()


def default_name(robot: RobotDescription) -> str:
    """The default name of a map: that of the robot, if it is a valid file name."""
    try:
        return storage.checked_name(robot.name)
    except MapFileError:
        return "map"


def abilities(robot: RobotDescription) -> Abilities:
    """The abilities of mapping on a robot.

    Raises:
        RobotFileError: Its map would have too many cells.
    """
    if robot.map_size / robot.map_resolution > MAX_EDGE_CELLS:
        problem = f"[mapping]: size / resolution is more than {MAX_EDGE_CELLS} cells"
        raise RobotFileError(str(robot.path), [problem])
    return Abilities(
        provides=(Capability.PRO_MAP, Capability.PRO_POINTS), needs=(Capability.NAV_STATE,)
    )


def main() -> int:
    """Run the process."""
    purpose = "Makes a map from range sensors, and keeps the mission: marks, map and track."
    return run_module(
        "mapping", purpose, abilities, lambda client, robot: Mapping(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
