"""From the tokens of rmw_zenoh to a robot's topics and services; pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from hub.errors import RosMessageError
from hub.robots.ros.line import RosGraph, RosService, RosTopic
from hub.ros.rmw_zenoh import HASH_OF_HUMBLE, Endpoint, Entity, EntityKind, parse_token
from hub.ros.type_hashes import later_definition

MOST_TOKENS: Final = 20_000
"""Most tokens that are kept; those after are counted as faults."""
_TOPIC_KINDS = (EntityKind.PUBLISHER, EntityKind.SUBSCRIBER)


class TokenGraph:
    """The nodes of a robot, as far as their tokens are known.

    Attributes:
        faults: Tokens that made no sense, or were too many.
        own: The session whose tokens do not count.
    """

    def __init__(self) -> None:
        self.faults = 0
        self.own = ""
        self._entities: dict[str, Entity] = {}
        self._ends: dict[tuple[EntityKind, str], list[Entity]] | None = {}
        self._graph: RosGraph | None = None

    def take(self, token: str, *, alive: bool) -> None:
        """Take a token that is there now, or no more."""
        found = self._read(token) if alive else self._entities.pop(token, None)
        if found is not None:
            self._ends = self._graph = None

    def clear(self) -> None:
        """Drop all tokens; `faults` and `own` stay."""
        self._entities.clear()
        self._ends = self._graph = None

    @property
    def graph(self) -> RosGraph:
        """Topics and services by name."""
        if self._graph is None:
            self._graph = self._made()
        return self._graph

    def endpoints(self, kind: EntityKind, name: str) -> tuple[Endpoint, ...]:
        """How nodes have a topic or service, in an order that stays."""
        found = self._by_end().get((kind, name), ())
        return tuple(each.endpoint for each in found if each.endpoint is not None)

    @property
    def is_humble(self) -> bool:
        """Whether the nodes are of ROS 2 Humble, whose types have no hash."""
        return any(
            each.endpoint is not None and each.endpoint.hash == HASH_OF_HUMBLE
            for each in self._entities.values()
        )

    def _read(self, token: str) -> Entity | None:
        if token in self._entities:
            return None
        try:
            found = parse_token(token)
        except RosMessageError:
            self.faults += 1
            return None
        if found.session == self.own:
            return None
        if len(self._entities) >= MOST_TOKENS:
            self.faults += 1
            return None
        self._entities[token] = found
        return found

    def _by_end(self) -> Mapping[tuple[EntityKind, str], list[Entity]]:
        if self._ends is None:
            self._ends = {}
            for token in sorted(self._entities):
                each = self._entities[token]
                if each.endpoint is not None:
                    self._ends.setdefault((each.kind, each.endpoint.name), []).append(each)
        return self._ends

    def _made(self) -> RosGraph:
        ends = self._by_end()
        names = sorted({name for kind, name in ends if kind in _TOPIC_KINDS})
        services = sorted(name for kind, name in ends if kind is EntityKind.SERVER)
        return RosGraph(
            distribution="humble" if self.is_humble else "",
            topics={name: self._topic(name) for name in names},
            services={
                name: RosService(name=name, type=self.endpoints(EntityKind.SERVER, name)[0].type)
                for name in services
            },
            whole=True,
        )

    def _topic(self, name: str) -> RosTopic:
        ends = self._by_end()
        publishers, subscribers = (ends.get((kind, name), []) for kind in _TOPIC_KINDS)
        said = [each.endpoint for each in (*publishers, *subscribers) if each.endpoint is not None]
        schema = later_definition(said[0].type, said[0].hash)
        return RosTopic(
            name=name,
            schema_name=said[0].type,
            encoding="cdr",
            schema_encoding="ros2msg" if schema else "",
            schema=schema.encode(),
            publishers=_nodes(publishers),
            subscribers=_nodes(subscribers),
        )


def _nodes(entities: Iterable[Entity]) -> tuple[str, ...]:
    return tuple(sorted({each.full_node_name for each in entities}))
