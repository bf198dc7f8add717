"""A hub without processor time answers HELLO late: its clients wait for it."""

from __future__ import annotations

from pathlib import Path

import zmq

from hub.ipc.client import Client
from hub.ipc.wire import control, control_codec
from tests.support.waiting import until

_LATE_S = 3.5
"""Later than the life of a socket that cannot connect."""


def test_a_client_keeps_its_connection_for_a_late_welcome(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    router = context.socket(zmq.ROUTER)
    monitor = router.get_monitor_socket(zmq.EVENT_ACCEPTED)
    router.bind(f"ipc://{tmp_path}/hub")
    client = Client("patient", f"ipc://{tmp_path}/hub")
    session = client.session.connection
    try:
        session.joined = (7, 1)  # it was connected before, so its sockets are short-lived
        session.start_over("the hub does not answer")
        until(lambda: router.poll(0), 10.0, meanwhile=lambda: client.listen(0.01))
        began = client.loop.clock()
        until(
            lambda: client.loop.clock() - began > _LATE_S,
            10.0,
            meanwhile=lambda: client.listen(0.05),
        )
        connections = 0
        while monitor.poll(0):
            monitor.recv_multipart()
            connections += 1
        sender, said = router.recv_multipart()
        while router.poll(0):
            sender, said = router.recv_multipart()
        hello = control_codec.unpack(said)
        assert isinstance(hello, control.Hello)
        welcome = control.Welcome(
            publisher=1,
            epoch=7,
            machine=hello.machine,
            sent=hello.sent,
            hub_time=0.0,
            near=False,
            ports=(0,) * 6,
            paths=("",) * 6,
        )
        router.send_multipart([sender, control_codec.pack(welcome)])
        until(lambda: client.number == 1, 10.0, meanwhile=lambda: client.listen(0.01))
        assert connections <= 2  # the first socket, and the one that it began with again
    finally:
        client.close()
        router.disable_monitor()
        monitor.close()
        router.close(0)
        context.term()
