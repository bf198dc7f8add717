"""The table of who may publish which message: every role, every message of the vocabulary."""

from __future__ import annotations

import itertools

import pytest

from hub.errors import NotAllowedError
from hub.gcm.catalog import MESSAGES
from hub.ipc.definition import Plane
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.security import publish_rights
from tests.support.cases import for_each

SUPERVISED = {"GCM_Common_Command", "GCM_Module_Command", "SIM_Pause"}
FOR_THE_ROBOT = {"GCM_Drive_Command", "GCM_Drive_Goal"}
COMMANDS = {each.name for each in MESSAGES if each.plane is Plane.COMMAND}
OPERATED = COMMANDS - SUPERVISED - FOR_THE_ROBOT
ALLOWED = {
    Role.OBSERVE: {"GCM_Stop"},
    Role.OPERATE: OPERATED,
    Role.SUPERVISE: OPERATED | SUPERVISED,
    Role.MODULE: {each.name for each in MESSAGES},
}


@for_each("role", Role)
def test_each_role_publishes_these_messages_and_no_others(role: Role) -> None:
    allowed = {
        each.name
        for each in MESSAGES
        if publish_rights.may_publish(role, each.name, each.plane.value)
    }
    assert allowed == ALLOWED[role]


@for_each("message", MESSAGES)
def test_refusal_names_the_least_role_and_never_a_module_key(message: object) -> None:
    name, plane = message.name, message.plane.value  # type: ignore[attr-defined]
    for role in Role:
        principal = Principal(name="alice", role=role)
        if publish_rights.may_publish(role, name, plane):
            continue
        with pytest.raises(NotAllowedError) as caught:
            publish_rights.demand_right(principal, "console", name, plane)
        text = str(caught.value)
        assert f"alice has a key to {role.value} and may not send {name}" in text
        assert "--role module" not in text
        least = next(each for each in Role if publish_rights.may_publish(each, name, plane))
        assert (f"--role {least.value}" in text) == (least is not Role.MODULE)


def test_each_role_may_do_what_the_one_before_it_may() -> None:
    for (less, more), message in itertools.product(itertools.pairwise(Role), MESSAGES):
        plane = message.plane.value
        before = publish_rights.may_publish(less, message.name, plane)
        assert before <= publish_rights.may_publish(more, message.name, plane)


def test_wheels_are_commanded_by_navigation_alone_also_on_this_machine() -> None:
    drive = "GCM_Drive_Command", "command"
    publish_rights.demand_right(LOCAL, "navigation", *drive)
    publish_rights.demand_right(Principal(name="far", role=Role.MODULE), "navigation", *drive)
    with pytest.raises(NotAllowedError, match="only the robot's module navigation sends it"):
        publish_rights.demand_right(LOCAL, "rune-hub-send-1", *drive)
    with pytest.raises(NotAllowedError, match="only the robot's module navigation sends it"):
        publish_rights.demand_right(Principal(name="op", role=Role.OPERATE), "navigation", *drive)


def test_commands_of_other_modules_are_for_operators_and_their_states_are_not() -> None:
    assert publish_rights.may_publish(Role.OPERATE, "MY_Gripper_Command", "command")
    assert not publish_rights.may_publish(Role.OBSERVE, "MY_Gripper_Command", "command")
    assert not publish_rights.may_publish(Role.SUPERVISE, "MY_Gripper_State", "state")


def test_a_stop_alone_passes_whatever_its_header_says() -> None:
    unordered = {name for name, right in publish_rights.COMMANDS.items() if right.unordered}
    assert unordered == {each.name for each in MESSAGES if each.unreadable is not None}
    assert unordered == {"GCM_Stop"}
