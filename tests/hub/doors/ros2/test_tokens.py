"""Tokens of other nodes, as many as they like: the node of a hub keeps some of them."""

from unittest import mock

from hub.doors.ros2.node_server import MOST_TOKENS, NodeSettings, RosNodeServer
from hub.ros.rmw_zenoh import Endpoint, Entity, EntityKind


def token(number: int) -> str:
    end = Endpoint(name=f"/t{number % 7}", type="std_msgs/msg/Bool", hash=f"RIHS01_{0:064x}")
    entity = Entity(
        session="ab", number=number, kind=EntityKind.SUBSCRIBER, node_name="n", endpoint=end
    )
    return entity.token(0)


def test_tokens_are_kept_up_to_a_bound_and_forgotten_when_they_go() -> None:
    session = mock.Mock(zid="cd")
    server = RosNodeServer(session, NodeSettings(), lambda: None)
    come = session.watch_tokens.call_args.args[1]
    for alive in (True, False, True):
        for number in range(MOST_TOKENS + 100):
            come(token(number), alive)
    assert server.refused == {"too many": 200}
