"""The mapping process: makes the map, keeps the interest points, answers for both, saves them."""

from __future__ import annotations

import logging
import math
import sys
import time

from hub.errors import HandlerFailedError, MapFileError, RobotFileError
from hub.folders import for_maps
from hub.gcm import map_coding, mapping, navigation
from hub.gcm.capability import Abilities, Capability
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.ipc.client import Client
from hub.ipc.reception import Reception
from hub.modules.mapping import storage
from hub.modules.mapping.grid import LOADED, MAX_EDGE_CELLS, GridPicture, OccupancyGrid
from hub.modules.mapping.points import PointBook
from hub.modules.mapping.scans import ScanSelector
from hub.robots.description import RobotDescription
from hub.runtime import publish_on_request, run_module

_logger = logging.getLogger(__name__)

_POINTS_PERIOD = 1.0 / mapping.INTEREST_POINTS.rate_hz


class Mapping:
    """Connects the map and the points with the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        """Subscribe and answer."""
        self._client = client
        self._robot = robot
        self._grid = OccupancyGrid(robot.map_resolution, robot.map_size)
        self._scans = ScanSelector()
        self._points = PointBook()
        self._stamp = 0.0
        client.subscribe(navigation.ROBOT_STATE, self._state)
        client.subscribe(mapping.POINT_COMMAND, self._point)
        client.respond(mapping.MAP_REQUEST, mapping.MAP, self._map)
        client.respond(mapping.MAP_COMMAND, COMMON_RESULT, self._command)
        client.define(mapping.INTEREST_POINTS)
        publish_on_request(client, mapping.INTEREST_POINTS, self._publish_points)
        client.every(_POINTS_PERIOD, self._publish_points)

    def finish(self) -> None:
        """Say what was left out."""
        if self._grid.outside:
            _logger.warning("%d scans were made outside of the map", self._grid.outside)

    def _state(self, state: navigation.RobotState, reception: Reception) -> None:
        scan = self._scans.scan(state, reception.measured)
        if scan is None:
            return
        if self._grid.add(scan.x, scan.y, scan.theta, scan.sonar, scan.infrared):
            self._stamp = state.stamp
        elif self._grid.outside == 1:
            _logger.warning("the robot has left the map, which ends %.1f m away", -self._grid.low)

    def _map(self, request: mapping.MapRequest) -> mapping.Map:
        picture: GridPicture | None
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
        data = map_coding.encode(picture.cells)
        return mapping.Map(
            stamp=self._stamp,
            resolution=picture.resolution,
            width_cells=picture.cells.shape[1],
            height_cells=picture.cells.shape[0],
            origin_x=picture.origin_x,
            origin_y=picture.origin_y,
            length=len(data),
            data=data,
        )

    def _point(self, command: mapping.PointCommand, reception: Reception) -> None:
        if command.action is mapping.PointAction.REMOVE:
            refused = self._points.remove(command.point.number)
        else:
            by = f"client {reception.publisher}"
            refused = self._points.mark(command.point, by, time.time())
        if refused:
            _logger.warning("point refused: %s", refused)
        else:
            self._publish_points()

    def _publish_points(self) -> None:
        self._client.publish(mapping.INTEREST_POINTS, self._points.message)

    def _command(self, command: mapping.MapCommand) -> CommonResult:
        try:
            text = self._carry_out(command)
        except MapFileError as error:
            _logger.warning("%s", error)
            return CommonResult(done=0, text=str(error))
        _logger.info("%s", text)
        return CommonResult(done=1, text=text)

    def _carry_out(self, command: mapping.MapCommand) -> str:
        """Do it, and say what was done.

        Raises:
            MapFileError: It cannot be done; nothing has changed.
        """
        if command.order is mapping.MapOrder.CLEAR:
            self._begin_anew()
            return f"the map is empty; {self._points.message.count} points are kept"
        folder = for_maps(self._robot.map_folder)
        name = storage.checked_name(command.name or default_name(self._robot))
        if command.order is mapping.MapOrder.SAVE:
            points = self._points.message.points
            path = storage.save(folder, name, self._grid.whole(), points)
            return f"map and {len(points)} points are saved as {path}"
        picture, points = storage.load(folder, name)
        self._begin_anew()
        lost = self._grid.paint(picture, LOADED)
        self._points.replace_all(points)
        self._publish_points()
        outside = f"; {lost} cells lie outside of this robot's map" if lost else ""
        return f"map {name} and {len(points)} points are loaded from {folder}{outside}"

    def _begin_anew(self) -> None:
        self._grid.clear()
        self._scans = ScanSelector()


def default_name(robot: RobotDescription) -> str:
    """What a map is called that nobody names: as the robot, where that can be a file's name."""
    try:
        return storage.checked_name(robot.name)
    except MapFileError:
        return "map"


def abilities(robot: RobotDescription) -> Abilities:
    """What mapping can do on a robot.

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
    purpose = "Makes a map from range sensors, keeps interest points on it, and saves both."
    return run_module(
        "mapping", purpose, abilities, lambda client, robot: Mapping(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
