"""Raw ZeroMQ: bytes in single frames through its own proxy, and a relay for queries.

What any bus on ZeroMQ could reach that checked and decoded nothing.
"""

from __future__ import annotations

import os
import threading

import zmq

from benchmarks.peers.job import HEAD, Job, ask_for, counter, drive
from benchmarks.peers.page import now

_TOPIC = b"Bench_Sample_0\0"
_QUEUE = 20_000


def _address(job: Job, place: int) -> str:
    if job.endpoint.startswith("ipc"):
        return f"{job.endpoint}.{place}"
    return f"tcp://127.0.0.1:{job.port + place}"


def _made(kind: int) -> zmq.Socket[bytes]:
    socket: zmq.Socket[bytes] = zmq.Context.instance().socket(kind)
    socket.linger = 0
    socket.sndhwm = socket.rcvhwm = _QUEUE
    return socket


def broker(job: Job) -> None:
    inward, outward, router = _made(zmq.XSUB), _made(zmq.XPUB), _made(zmq.ROUTER)
    inward.bind(_address(job, 1))
    outward.bind(_address(job, 2))
    router.bind(_address(job, 0))
    threading.Thread(target=zmq.proxy, args=(inward, outward), daemon=True).start()
    while True:
        sender, receiver, body = router.recv_multipart()
        router.send_multipart((receiver, sender, body))


def send(job: Job) -> None:
    page, socket = job.open(), _made(zmq.PUB)
    socket.connect(_address(job, 1))
    put, pack, rest = socket.send, HEAD.pack, os.urandom(job.size - HEAD.size)
    drive(job, page, lambda number: put(_TOPIC + pack(number, now()) + rest))


def receive(job: Job) -> None:
    take, socket = counter(job), _made(zmq.SUB)
    socket.connect(_address(job, 2))
    socket.subscribe(_TOPIC)
    receive_one, unpack, start = socket.recv, HEAD.unpack_from, len(_TOPIC)
    while True:
        take(*unpack(receive_one(), start))


def _dealer(job: Job, name: bytes) -> zmq.Socket:
    socket = _made(zmq.DEALER)
    socket.routing_id = name
    socket.connect(_address(job, 0))
    return socket


def ask(job: Job) -> None:
    page, socket, rest = job.open(), _dealer(job, b"asker"), bytes(job.size - 8)
    socket.rcvtimeo = 500

    def ask_one(number: int) -> int:
        socket.send_multipart((b"answerer", number.to_bytes(8, "little") + rest))
        while True:  # an answer to an earlier question may come late
            answer = int.from_bytes(socket.recv_multipart()[1][:8], "little")
            if answer == number:
                return answer

    ask_for(job, page, ask_one)


def answer(job: Job) -> None:
    socket = _dealer(job, b"answerer")
    while True:
        socket.send_multipart(socket.recv_multipart())
