"""The map of a robot is asked for while the layout shows it, and then no more."""

from __future__ import annotations

import dataclasses
from contextlib import closing
from pathlib import Path

import numpy as np

from hub.gcm import map_coding
from hub.gcm.mapping import MAP, MAP_REQUEST, Map, MapRequest
from hub.gcm.supervision import MODULE_INFO, ModuleInfo
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from rune_tui.layout.spec import CapabilitySpec, RobotSpec
from rune_tui.link.robot_link import RobotLink
from tests.support.waiting import until

CELLS = np.array([[0, 100, -1], [0, 0, 0]], np.int8)
OFTEN = (CapabilitySpec(name="PRO_MAP", interval_s=0.02),)


def test_a_layout_that_shows_the_map_asks_for_it_again_and_again(tmp_path: Path) -> None:
    asked: list[MapRequest] = []
    infos: list[ModuleInfo] = []

    def answer(request: MapRequest) -> Map:
        asked.append(request)
        return Map(
            stamp=0.0,
            resolution=0.5,
            width_cells=3,
            height_cells=2,
            origin_x=-1.0,
            origin_y=2.0,
            data=map_coding.encode(CELLS),
        )

    endpoint = f"ipc://{tmp_path}/central"
    shows = RobotSpec(
        name="robot", hub=endpoint, capabilities=OFTEN, messages=frozenset({MAP.name})
    )
    hides = dataclasses.replace(shows, messages=frozenset())
    with closing(Central([endpoint])), closing(Client("mapping", endpoint)) as mapping:
        mapping.subscribe(MODULE_INFO, lambda info, _: infos.append(info))
        mapping.respond(MAP_REQUEST, MAP, answer)
        mapping.wait_defined(5.0)
        with closing(RobotLink(hides)) as link:
            link.start()
            until(lambda: mapping.listen(0.05) or len(infos) > 1, 10.0)
            assert asked == [], "two seconds of a layout without a map"
            link.follow(shows)
            until(lambda: mapping.listen(0.05) or len(asked) > 2, 10.0)
            until(lambda: link.state.map is not None, 10.0)
            assert link.state.map is not None
            assert np.array_equal(link.state.map.value.cells, CELLS)
            assert np.isnan(asked[0].x), "the whole map is wanted"
