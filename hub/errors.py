"""Every error the hub raises on purpose.

    HubError
    ├── MessageFormatError (ValueError)        a format string that is not one: "{int,"
    ├── CodecError (ValueError)                values or bytes that do not fit their format
    │   └── RangeError                         a value outside what its message declares
    ├── FrameError (ValueError)                bytes from the wire that are no frame of Rune
    ├── UndefinedMessageError (LookupError)    a message that is not defined at this central
    ├── RedefinedMessageError (ValueError)     the same name defined with another format
    ├── UnknownModuleError (LookupError)       no module of this name is connected
    ├── CentralUnreachableError (ConnectionError)  no hub answers at the endpoint
    ├── NameTakenError (ConnectionError)       another live module has this name
    ├── EndpointError (OSError)                a port that is busy, an address that is not allowed
    ├── RouterUnreachableError (ConnectionError)   no Zenoh router answers
    ├── FleetKeyError (ValueError)             a key of a fleet, or a name in it, that is none
    ├── FleetRefusalError (ValueError)         a command or query from a fleet that is refused
    ├── KeyFileError (ValueError)              a file of keys that is damaged, lost, or not private
    ├── KeyNameError (ValueError)              a name of a key that is taken, unknown or malformed
    ├── NotAllowedError (PermissionError)      what the role of a client's key does not allow
    ├── QueryError (RuntimeError)              a query that ended without an answer
    │   ├── NoHandlerError                     no module answers queries of this name
    │   ├── HandlerDiedError                   the module that was asked is gone
    │   ├── HandlerFailedError                 the module that was asked could not answer
    │   ├── NoValueError                       no module has published a value to ask for
    │   └── QueryTimeoutError (TimeoutError)   the answer did not come in time
    ├── CameraError (OSError)                a camera that gives no pictures, and why
    ├── ArenaError (ValueError)                an arena file with mistakes, all of them listed
    ├── LinkShaperError (RuntimeError)         a link shaper that could not be started
    ├── DoorError (RuntimeError)               a door to another system that could not be opened
    ├── UnknownKindError (LookupError)         a kind of robot that is not known, or not usable
    ├── RobotFileError (ValueError)            a robot file with mistakes, all of them listed
    ├── VehicleAddressError (ValueError)       an address of a vehicle that is none
    ├── VehicleSilentError (ConnectionError)   no vehicle, or no answer, at an address
    ├── RosSilentError (ConnectionError)       no robot with ROS answers at an address
    ├── ParameterFileError (ValueError)        a file of a vehicle's parameters that cannot be used
    ├── LinkProfileError (ValueError)          a profile of a link with mistakes, all of them listed
    ├── RecordingError (ValueError)            a recording that is damaged, or of a form not known
    ├── MapFileError (ValueError)              files of a map that cannot be written or read
    └── ModuleStartError (RuntimeError)        a module that could not be started

The text of an error says what happened, where, and what to do, in one sentence.
"""

from __future__ import annotations

from collections.abc import Sequence


class HubError(Exception):
    """Root of the hub's errors."""


class MessageFormatError(HubError, ValueError):
    """A format string that does not follow the grammar.

    Attributes:
        position: Index of the offending character in the format string.
    """

    def __init__(self, text: str, position: int, reason: str) -> None:
        self.position = position
        shown = text if len(text) <= 80 else text[:77] + "..."
        super().__init__(f"format {shown!r}, position {position}: {reason}")


class CodecError(HubError, ValueError):
    """Values that do not fit a format, or bytes that no values of it make."""


class RangeError(CodecError):
    """A value that is not within what its message declares."""


class FrameError(HubError, ValueError):
    """Bytes that are no frame of this protocol."""


class UndefinedMessageError(HubError, LookupError):
    """A message that is not defined at this central."""


class RedefinedMessageError(HubError, ValueError):
    """A message that is already defined with another format."""


class UnknownModuleError(HubError, LookupError):
    """No module of this name is connected."""


class CentralUnreachableError(HubError, ConnectionError):
    """No central answers at the endpoint."""


class OtherVersionError(CentralUnreachableError):
    """The hub has another version of the protocol."""


class NameTakenError(HubError, ConnectionError):
    """Another live module is connected under this name."""


class EndpointError(HubError, OSError):
    """An endpoint that cannot be used: busy, malformed or not allowed."""


class RouterUnreachableError(HubError, ConnectionError):
    """No Zenoh router answers at an endpoint."""


class FleetKeyError(HubError, ValueError):
    """A key of a fleet that is none, or a name that cannot stand in one."""

    def __init__(self, text: str, reason: str) -> None:
        shown = text if len(text) <= 80 else text[:77] + "..."
        super().__init__(f"{shown!r} cannot be used in a fleet: {reason}")


class FleetRefusalError(HubError, ValueError):
    """A command or a query from a fleet that is not carried out."""


class KeyFileError(HubError, ValueError):
    """A file of keys that cannot be used: damaged, missing, or open to others."""

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(f"key file {path} cannot be used: {reason}")


class KeyNameError(HubError, ValueError):
    """A name that no key can have, that another key has, or that none has."""


class NotAllowedError(HubError, PermissionError):
    """Something that the role of a client's key does not allow."""


class QueryError(HubError, RuntimeError):
    """A query that ended without an answer."""


class NoHandlerError(QueryError):
    """No connected module answers queries of this name."""


class HandlerDiedError(QueryError):
    """The module that was asked went away before it answered."""


class HandlerFailedError(QueryError):
    """The module that was asked reported that it cannot answer."""


class NoValueError(QueryError):
    """No module has published a value to answer with."""


class QueryTimeoutError(QueryError, TimeoutError):
    """The answer did not come within the time the caller gave."""


class CameraError(HubError, OSError):
    """A camera that gives no pictures."""


class _FileError(HubError, ValueError):
    """A file with mistakes, all of them listed.

    Attributes:
        problems: One sentence for each mistake.
    """

    def __init__(self, path: str, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__(at_lines(path, problems))


def at_lines(path: str, problems: Sequence[str]) -> str:
    """The problems of a file, each on a line of its own that begins as compilers write it."""
    return "\n".join(path + _placed(problem) for problem in problems)


def _placed(problem: str) -> str:
    """What follows the name of the file, as compilers write it: ":12: sentence"."""
    line, colon, rest = problem.removeprefix("line ").partition(": ")
    if problem.startswith("line ") and colon and line.isdigit():
        return f":{line}: {rest}"
    return f": {problem}"


class ArenaError(_FileError):
    """An arena file with mistakes, all of them listed in `problems`."""


class RobotFileError(_FileError):
    """A robot file with mistakes, all of them listed in `problems`."""


class LinkProfileError(_FileError):
    """A profile of a link with mistakes, all of them listed in `problems`."""


class LinkShaperError(HubError, RuntimeError):
    """A link shaper that could not be started."""


class DoorError(HubError, RuntimeError):
    """A door of a hub to another system that could not be opened."""


class UnknownKindError(HubError, LookupError):
    """An unknown kind of robot, or one with an unusable Python file."""


class VehicleAddressError(HubError, ValueError):
    """An address of a vehicle that is none."""

    def __init__(self, text: str, reason: str) -> None:
        shown = text if len(text) <= 80 else text[:77] + "..."
        super().__init__(f"{shown!r} is no address of a vehicle: {reason}")


class VehicleSilentError(HubError, ConnectionError):
    """No vehicle is at an address, or the one there does not answer."""


class AutopilotSettingError(HubError, ValueError):
    """A setting of a simulated autopilot that it does not have."""

    def __init__(self, name: str, reason: str) -> None:
        super().__init__(f"{name[:40]!r}: {reason}")


class ParameterFileError(HubError, ValueError):
    """A file of a vehicle's parameters that cannot be written or read."""


class RosAddressError(HubError, ValueError):
    """A text that is no address of a robot with ROS."""


class RosSilentError(HubError, ConnectionError):
    """No bridge or router of a robot with ROS answers at an address."""


class MapFileError(HubError, ValueError):
    """Files of a map that cannot be written or read."""


class RecordingError(HubError, ValueError):
    """A recording, or a part of it, that cannot be read or written."""


class RosMessageError(HubError, ValueError):
    """A message of ROS or Foxglove, or its definition, that cannot be read."""


class MissionError(HubError, ValueError):
    """Something about a mission that cannot be done; nothing has changed."""


class MissionFileError(MissionError):
    """Files of a mission that cannot be written or read."""


class ModuleStartError(HubError, RuntimeError):
    """A module process that could not be started."""
