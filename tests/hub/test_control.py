"""The control lease on a real central: who gets control, whose commands a module follows."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hub.control_gate import ControlGate, follow_control
from hub.errors import HandlerFailedError, HubError
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import (
    CONSOLE_HEARTBEAT,
    CONTROL_REFUSAL,
    CONTROL_REQUEST,
    CONTROL_STATE,
    ConsoleHeartbeat,
    ControlAction,
    ControlRefusal,
    ControlRequest,
    ControlState,
)
from hub.gcm.navigation import GOAL_COMMAND, GoalCommand
from hub.gcm.supervision import MODULE_INFO, ModuleInfo
from hub.inspection import control_commands, message_commands
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring
from hub.ipc.security.publish_rights import ROBOMON
from hub.ipc.transport.loop import Loop
from hub.robomon.control_service import ControlService
from tests.support.waiting import until

HOLDS = ConsoleHeartbeat(holds=1)


class Robot:
    """Central, the daemon's desk, and a module that follows goals of those who may send them."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._stack = stack
        self._keyring = Keyring(folder / "keys")
        local = f"ipc://{folder}/central"
        gateway = curve_gateway("tcp://127.0.0.1:0", self._keyring)
        self.central = Central([local], gateways=[gateway])
        stack.callback(self.central.close)
        self.loop = Loop()
        stack.callback(self.loop.close)
        self.followed: list[tuple[int, int]] = []
        self.changes: list[tuple[int, int]] = []
        self.desk = ControlService(self.client("robomon"), self.central.peer_of)
        module = self.client("navigation")
        self.gate = ControlGate(
            module, lambda now, before: self.changes.append((now.owner, before))
        )
        module.subscribe(
            GOAL_COMMAND,
            lambda goal, how: (
                self.gate.admits(GOAL_COMMAND, how)
                and self.followed.append((how.publisher, int(goal.theta)))
            ),
        )
        self.states: list[ControlState] = []
        self.refusals: list[ControlRefusal] = []
        watcher = self.client("watcher")
        watcher.subscribe(CONTROL_STATE, lambda state, _: self.states.append(state), last=True)
        watcher.subscribe(CONTROL_REFUSAL, lambda refusal, _: self.refusals.append(refusal))
        self.until(lambda: self.states)

    def client(self, name: str, role: Role | None = None) -> Client:
        """Somebody on the robot, or the holder of a key elsewhere."""
        keys = read_client_keys(self._keyring.make(name, role)) if role else None
        endpoint = self.central.endpoints[-1 if role else 0]
        client = self._stack.enter_context(
            closing(Client(name, endpoint, loop=self.loop, keys=keys))
        )
        client.wait_connected(10.0)
        return client

    def until(self, condition: object) -> None:
        assert callable(condition)
        until(condition, 15.0, meanwhile=lambda: self.loop.listen(0.02))

    def until_owned_by(self, client: Client | None) -> None:
        number = client.number if client else 0
        self.until(lambda: self.states[-1].owner == number and self.gate.obeys(number))

    def send_goal(self, client: Client, number: int) -> None:
        client.define(GOAL_COMMAND)
        client.publish(GOAL_COMMAND, GoalCommand(theta=float(number)))


def want(client: Client, action: ControlAction) -> CommonResult:
    request = ControlRequest(action=action, operator=client.name)
    return client.query_response(CONTROL_REQUEST, request, COMMON_RESULT, timeout=10.0)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    with ExitStack() as stack:
        yield Robot(tmp_path, stack)


def test_state_of_control_counts_once_its_sender_is_the_daemon() -> None:
    learned: list[int] = []
    given: dict[str, Any] = {}
    client: Any = SimpleNamespace(
        directory=SimpleNamespace(follow=given.__setitem__),
        subscribe=lambda definition, came, **_: given.__setitem__(definition.name, came),
    )
    follow_control(client, lambda state: learned.append(state.owner))
    connected, came = given[ROBOMON], given[CONTROL_STATE.name]
    for publisher in (0, 7, 5):
        came(ControlState(owner=publisher), MessageInfo(publisher, 1, 0, 0.0, 0.0))
    assert learned == []
    connected(5)
    came(ControlState(owner=8), MessageInfo(7, 2, 0, 0.0, 0.0))
    assert learned == [5]
    connected(0)
    came(ControlState(owner=9), MessageInfo(5, 2, 0, 0.0, 0.0))
    came(ControlState(owner=9), MessageInfo(0, 2, 0, 0.0, 0.0))
    connected(6)
    came(ControlState(owner=6), MessageInfo(6, 1, 0, 0.0, 0.0))
    assert learned == [5, 6]


def test_only_the_owners_commands_count_and_the_others_are_told(robot: Robot) -> None:
    alice, bob = robot.client("alice"), robot.client("bob")
    for client in (alice, bob):
        robot.send_goal(client, 1)
        robot.until(lambda client=client: (client.number, 1) in robot.followed)
    assert want(alice, ControlAction.TAKE).done
    assert not want(bob, ControlAction.TAKE).done
    robot.until_owned_by(alice)
    for number in (2, 3, 4):
        robot.send_goal(bob, number)
    robot.until(lambda: robot.gate.refused == 3)
    robot.send_goal(alice, 5)
    robot.until(lambda: (alice.number, 5) in robot.followed and robot.refusals)
    assert not [number for sender, number in robot.followed if sender == bob.number][1:]
    # Told once, however often it is tried within a second.
    assert robot.refusals == [
        ControlRefusal(
            sender=bob.number,
            message=GOAL_COMMAND.name,
            owner=alice.number,
            operator="alice",
            refused=1,
        )
    ]


@pytest.mark.parametrize("role", [None, Role.MODULE], ids=["local", "far"])
def test_only_the_daemon_says_who_has_control(robot: Robot, role: Role | None) -> None:
    alice, evil = robot.client("alice"), robot.client("evil", role)
    assert want(alice, ControlAction.TAKE).done
    robot.until_owned_by(alice)
    evil.define(CONTROL_STATE)
    forged = ControlState(owner=evil.number, operator="forged")
    evil.publish(CONTROL_STATE, forged)
    robot.until(lambda: forged.operator in {each.operator for each in robot.states})
    evil.publish(CONTROL_STATE, forged)
    robot.send_goal(evil, 1)
    robot.until(lambda: robot.gate.refused)
    assert robot.followed == []
    assert [owner for owner, _ in robot.changes] == [alice.number]


def test_modules_of_the_robot_are_followed_whoever_has_control(robot: Robot) -> None:
    alice, autonomy = robot.client("alice"), robot.client("autonomy")
    info = ModuleInfo(name="autonomy", pid=1, state="running", capabilities="AUT_PILOT")
    autonomy.define(MODULE_INFO)
    autonomy.publish(MODULE_INFO, info)
    want(alice, ControlAction.TAKE)
    robot.until_owned_by(alice)
    robot.until(lambda: robot.gate.obeys(autonomy.number))
    robot.send_goal(autonomy, 6)
    robot.until(lambda: (autonomy.number, 6) in robot.followed)
    autonomy.close()
    robot.until(lambda: not robot.states[-1].modules.size)


def test_an_operator_is_no_module_whoever_says_so(robot: Robot) -> None:
    alice, eve = robot.client("alice"), robot.client("eve", Role.OPERATE)
    want(alice, ControlAction.TAKE)
    robot.until_owned_by(alice)
    info = ModuleInfo(name="eve", pid=1, state="running", capabilities="AUT_PILOT")
    for number, counts in ((eve.number, False), (12345, False), (alice.number, True)):
        reception = MessageInfo(publisher=number, sequence=1, missed=0, age=0.0, measured=0.0)
        robot.desk.announced(info, reception)
        modules = robot.desk.state().modules.tolist()
        assert (number in modules) == counts  # alice is on the robot, and may be one


def test_a_console_that_announces_itself_does_not_pass_the_gate(robot: Robot) -> None:
    alice, bob = robot.client("alice"), robot.client("bob")
    want(alice, ControlAction.TAKE)
    robot.until_owned_by(alice)
    reception = MessageInfo(publisher=bob.number, sequence=1, missed=0, age=0.0, measured=0.0)
    for capabilities in ("CON_REAL", "AUT_PILOT CON_REAL"):
        info = ModuleInfo(name="bob", pid=1, state="running", capabilities=capabilities)
        robot.desk.announced(info, reception)
        assert robot.desk.state().modules.tolist() == []


def test_control_is_handed_over_on_request(robot: Robot) -> None:
    alice, bob = robot.client("alice"), robot.client("bob")
    want(alice, ControlAction.TAKE)
    assert "10 s" in want(bob, ControlAction.ASK).text
    robot.until(lambda: robot.states[-1].asker_operator == "bob")
    assert 0.0 < robot.states[-1].left_s <= 10.0
    assert want(alice, ControlAction.GRANT).done
    robot.until_owned_by(bob)
    assert robot.states[-1].why == "alice handed control to bob"
    assert robot.changes[-1] == (bob.number, alice.number)


def test_owner_that_leaves_frees_the_robot_at_once(robot: Robot) -> None:
    alice = robot.client("alice")
    want(alice, ControlAction.TAKE)
    robot.until_owned_by(alice)
    alice.close()
    robot.until_owned_by(None)
    assert "left" in robot.states[-1].why


def test_owner_that_falls_silent_frees_the_robot_and_is_warned_of_before(robot: Robot) -> None:
    alice = robot.client("alice")
    want(alice, ControlAction.TAKE)
    timer = alice.every(0.1, lambda: alice.publish(CONSOLE_HEARTBEAT, HOLDS))
    robot.until(lambda: robot.states[-1].held_s > 0.5)
    assert robot.states[-1].silent_s < 0.5
    timer.cancel()
    robot.until_owned_by(None)
    assert "silent" in robot.states[-1].why
    assert any(state.silent_s >= 1.0 for state in robot.states if state.owner)


@pytest.mark.parametrize("action", [ControlAction.TAKE_OVER, ControlAction.FREE])
@pytest.mark.parametrize(("role", "done"), [(Role.OPERATE, 0), (Role.SUPERVISE, 1), (None, 1)])
def test_control_is_taken_from_others_by_supervisors_and_on_the_robot_only(
    robot: Robot, role: Role | None, done: int, action: ControlAction
) -> None:
    owner, other = robot.client("owner", Role.OPERATE), robot.client("other", role)
    want(owner, ControlAction.TAKE)
    robot.until_owned_by(owner)
    answer = want(other, action)
    assert answer.done == done
    if done:
        robot.until_owned_by(other if action is ControlAction.TAKE_OVER else None)
    else:
        assert "--role supervise" in answer.text
        assert robot.states[-1].owner == owner.number


def test_nobody_asks_in_the_name_of_another(robot: Robot) -> None:
    boss, eve = robot.client("boss", Role.SUPERVISE), robot.client("eve", Role.OPERATE)
    eve.session.connection.publisher = boss.number
    with pytest.raises(HandlerFailedError, match="under a number not its own"):
        want(eve, ControlAction.TAKE_OVER)


def test_commands_show_who_has_control_and_free_the_robot(
    robot: Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    alice, bob, tool = robot.client("alice"), robot.client("bob"), robot.client("tool")
    assert control_commands.show(tool, as_json=False) == 0
    assert capsys.readouterr().out.splitlines()[0] == "nobody has control"
    want(alice, ControlAction.TAKE)
    want(bob, ControlAction.ASK)
    assert control_commands.show(tool, as_json=False) == 0
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("alice (alice) has had control for 0.")
    assert second.startswith("bob (bob) asks for it, ")
    assert control_commands.show(tool, as_json=True) == 0
    assert json.loads(capsys.readouterr().out)["operator"] == "alice"
    with pytest.raises(HubError, match="add --force"):
        control_commands.release(tool, force=False)
    assert control_commands.release(tool, force=True) == 0
    assert capsys.readouterr().out == "control was taken from alice\n"
    robot.until_owned_by(None)


def test_who_sends_what_is_refused_is_told_so(
    robot: Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    tool = robot.client("tool")
    goal = functools.partial(
        message_commands.send, tool, GOAL_COMMAND.name, [], rate_hz=0.0, zero_first=False
    )
    assert goal() == 0
    want(robot.client("alice"), ControlAction.TAKE)
    assert goal() == 1
    assert "alice has control, so the robot refuses this" in capsys.readouterr().err
    message_commands.send(tool, "GCM_Stop", [], rate_hz=0.0, zero_first=False)
    assert "has control" not in capsys.readouterr().err
