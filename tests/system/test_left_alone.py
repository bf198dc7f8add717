"""What robots do by themselves when they lose their operator: the driver tells their hardware."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import CONTROL_REQUEST, CONTROL_STATE, ControlAction, ControlRequest
from hub.ipc.client import Client
from tests.support.waiting import until
from tests.system import diving_robot
from tests.system.harness import HubProcess

SAFETY = """
[safety]
left_alone = "{action}"
surface_after_s = 0.3
"""
ROOT = str(Path(__file__).parents[2])


def take_control(client: Client) -> None:
    """Take it, and keep it until everybody has been told twice."""
    told: list[bool] = []
    client.subscribe(CONTROL_STATE, lambda state, _: told.append(state.owner == client.number))
    client.wait_connected(5.0)
    request = ControlRequest(action=ControlAction.TAKE, operator="alice")
    answer = client.query_response(CONTROL_REQUEST, request, COMMON_RESULT, timeout=5.0)
    assert answer.done, answer.text
    until(lambda: sum(told) >= 2, 10.0, meanwhile=lambda: client.listen(0.02))


@pytest.mark.parametrize(
    ("action", "does"),
    [("surface", ["stand", "surface"]), ("hold height", ["hold height"]), ("stand", ["stand"])],
)
def test_a_robot_whose_operator_leaves_does_what_its_file_says_until_there_is_another(
    start_hub: Callable[..., HubProcess],
    tmp_path: Path,
    stack: ExitStack,
    action: str,
    does: list[str],
) -> None:
    actions = tmp_path / "actions"
    actions.touch()
    hub = start_hub(
        environment={diving_robot.VARIABLE: str(actions), "PYTHONPATH": ROOT},
        modules=("driver",),
        kind=diving_robot.KIND_NAME,
        tables=SAFETY.format(action=action),
    )
    with closing(Client("alice", hub.endpoint)) as client:
        take_control(client)
    until(lambda: actions.read_text().splitlines() == does, 10.0, actions.read_text)
    take_control(stack.enter_context(closing(Client("bob", hub.endpoint))))
    until(lambda: actions.read_text().splitlines() == [*does, "operated"], 10.0, actions.read_text)
