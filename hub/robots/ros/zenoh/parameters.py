"""Parameters of nodes, which ROS 2 reads by services of each node."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import Final

from hub.errors import CodecError, RosMessageError
from hub.ipc.formats.codec import Codec
from hub.ipc.formats.grammar import Primitive, Struct, VariableArray
from hub.robots.ros.line import Payload, RosLine, RosTopic, TakeParameters
from hub.ros.decoding import RosDecoder
from hub.ros.values import RosValue

MOST_NODES: Final = 200
"""Most nodes that are asked."""
_TEXTS = VariableArray(Primitive("string"), ())
_NAMES = Codec(Struct((_TEXTS,)))
_PREFIXES = Codec(Struct((_TEXTS, Primitive("ulong"))))
_FIELDS: Final = (
    *("bool_value", "integer_value", "double_value", "string_value", "byte_array_value"),
    *("bool_array_value", "integer_array_value", "double_array_value", "string_array_value"),
)
"""Where a value is, by its type, from 1."""
_LIST, _GET = "list_parameters", "get_parameters"
_ANSWERS: Final = {
    _LIST: b"rcl_interfaces/ListParametersResult result\n",
    _GET: b"rcl_interfaces/ParameterValue[] values\n",
}


class ParameterQuestion:
    """One question for parameters, to all nodes that it concerns."""

    def __init__(self, line: RosLine, answered: TakeParameters, timeout: float) -> None:
        self._line, self._answered, self._timeout = line, answered, timeout
        self._found: dict[str, object] = {}
        self._open = 0

    def ask(self, names: tuple[str, ...]) -> None:
        """Ask for parameters such as "/controller.timeout"; none: for all."""
        by_node: dict[str, list[str]] = defaultdict(list)
        for name in names:
            node, _, bare = name.partition(".")
            if bare:
                by_node[node].append(bare)
        self._open = 1  # so that it does not end before all are asked
        if names:
            for node, wanted in by_node.items():
                self._get(node, wanted)
        else:
            for service in self._line.graph.services:
                node, _, kind = service.rpartition("/")
                if kind == _LIST and self._open <= MOST_NODES:
                    self._list(node)
        self._end_one()

    def _list(self, node: str) -> None:
        def read(answer: RosValue) -> None:
            names = [str(each) for each in answer.get("result.names")]
            if names:
                self._get(node, names)

        self._call(node, _LIST, b"".join(_PREFIXES.encode(([], 0))), read)

    def _get(self, node: str, names: list[str]) -> None:
        def read(answer: RosValue) -> None:
            for name, value in zip(names, answer.get("values"), strict=False):
                kind = int(value.get("type"))
                if 1 <= kind <= len(_FIELDS):
                    self._found[f"{node}.{name}"] = value.get(_FIELDS[kind - 1])

        try:
            self._call(node, _GET, b"".join(_NAMES.encode((names,))), read)
        except CodecError:
            return  # a name that no parameter has

    def _call(self, node: str, kind: str, payload: bytes, read: Callable[[RosValue], None]) -> None:
        service = f"{node}/{kind}"
        answers = RosTopic(
            name=service,
            schema_name="rcl_interfaces/msg/Answer",
            encoding="cdr",
            schema_encoding="ros2msg",
            schema=_ANSWERS[kind],
        )

        def answered(answer: Payload | None, _: str) -> None:
            try:
                if answer is not None:
                    read(RosDecoder.of(answers).decode(answer))
            except RosMessageError:
                pass  # as if the node had no such parameters
            finally:
                self._end_one()

        self._open += 1
        self._line.call(service, payload, answered, self._timeout)

    def _end_one(self) -> None:
        self._open -= 1
        if not self._open:
            self._answered(self._found)
