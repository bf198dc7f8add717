"""Every command of the vocabulary says who may send it."""

from __future__ import annotations

from hub.gcm.catalog import MESSAGES
from hub.ipc.definition import Plane
from hub.ipc.security.publish_rights import COMMANDS


def test_every_command_has_its_line_in_the_table_of_rights() -> None:
    defined = {each.name for each in MESSAGES if each.plane is Plane.COMMAND}
    assert set(COMMANDS) == defined, "write it into hub/ipc/security/publish_rights.py"
