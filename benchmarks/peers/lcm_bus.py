"""LCM: UDP multicast on this machine, no broker."""

from __future__ import annotations

import lcm

from benchmarks.peers.job import Job, counter, drive, maker, reader

_ADDRESS = "udpm://239.255.76.67:{port}?ttl=0&recv_buf_size=8000000"


def send(job: Job) -> None:
    page, make = job.open(), maker(job)
    bus = lcm.LCM(_ADDRESS.format(port=job.port))
    drive(job, page, lambda number: bus.publish("BENCH", make(number)))


def receive(job: Job) -> None:
    read = reader(job.size, counter(job))
    bus = lcm.LCM(_ADDRESS.format(port=job.port))
    subscription = bus.subscribe("BENCH", lambda _channel, data: read(data))
    subscription.set_queue_capacity(10_000)
    while True:
        bus.handle()
