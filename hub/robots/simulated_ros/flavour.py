"""How bridges of ROS 1 and ROS 2 write types, definitions and messages."""

from __future__ import annotations

from typing import Final

from hub.ros.definition_texts import definition_text, short_name
from hub.ros.encoding import RosEncoder, encoder_of
from hub.values import dataclass

_TRIGGER_ANSWER: Final = "bool success\nstring message\n"


@dataclass(frozen=True, slots=True, kw_only=True)
class RosFlavour:
    """A version of ROS behind a bridge.

    Attributes:
        encoding: Of messages: "cdr" or "ros1".
        schema_encoding: Of definitions: "ros2msg" or "ros1msg".
        encodings: What the bridge takes from its clients.
        timeout: Name of the controller's parameter `cmd_vel_timeout`.
        rate: Name of the controller's parameter `publish_rate`.
        simulated_time: Name of the parameter `use_sim_time`.
    """

    encoding: str
    schema_encoding: str
    encodings: tuple[str, ...]
    timeout: str
    rate: str
    simulated_time: str

    def type_name(self, name: str) -> str:
        """A type's name in this version, from that of ROS 2."""
        return short_name(name) if self.encoding == "ros1" else name

    def definition(self, name: str) -> bytes:
        """The definition of a known type."""
        return definition_text(name, self.schema_encoding).encode()

    def encoder(self, name: str) -> RosEncoder:
        """The encoder of a known type."""
        return encoder_of(name, self.encoding, definition_text(name, self.schema_encoding))

    def trigger_answer(self, text: str) -> bytes:
        """The answer of a std_srvs/Trigger that has worked."""
        encoder = encoder_of("std_srvs/TriggerResponse", self.encoding, _TRIGGER_ANSWER)
        return encoder.encode({"success": True, "message": text})

    @property
    def trigger(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Names and definitions of the request and the answer of std_srvs/Trigger."""
        kind, joint = self.type_name("std_srvs/srv/Trigger"), "" if self.encoding == "ros1" else "_"
        return (f"{kind}{joint}Request", ""), (f"{kind}{joint}Response", _TRIGGER_ANSWER)


ROS_2: Final = RosFlavour(
    encoding="cdr",
    schema_encoding="ros2msg",
    encodings=("cdr", "json"),
    timeout="/diff_drive_controller.cmd_vel_timeout",
    rate="/diff_drive_controller.publish_rate",
    simulated_time="/diff_drive_controller.use_sim_time",
)
ROS_1: Final = RosFlavour(
    encoding="ros1",
    schema_encoding="ros1msg",
    encodings=("ros1",),
    timeout="/diff_drive_controller/cmd_vel_timeout",
    rate="/diff_drive_controller/publish_rate",
    simulated_time="/use_sim_time",
)
