"""Eclipse Zenoh: a router between clients, with its shared memory or without."""

from __future__ import annotations

import signal
import threading

import zenoh

from benchmarks.peers.job import (
    Job,
    ask_for,
    counter,
    drive,
    maker,
    reader,
    sample,
    sample_bytes,
    sample_from,
)

_KEY, _ASK = "bench/t", "bench/ask"


def _session(job: Job, mode: str) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", f'"{mode}"')
    side = "listen" if mode == "router" else "connect"
    config.insert_json5(f"{side}/endpoints", f'["tcp/127.0.0.1:{job.port}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("scouting/gossip/enabled", "false")
    shared = "true" if job.options.get("shared_memory", True) else "false"
    config.insert_json5("transport/shared_memory/enabled", shared)
    return zenoh.open(config)


def broker(job: Job) -> None:
    session = _session(job, "router")
    signal.pause()
    session.close()


def send(job: Job) -> None:
    page, session, make = job.open(), _session(job, "client"), maker(job)
    publisher = session.declare_publisher(_KEY, congestion_control=zenoh.CongestionControl.BLOCK)
    drive(job, page, lambda number: publisher.put(make(number)))


def receive(job: Job) -> None:
    read, session = reader(job.size, counter(job)), _session(job, "client")
    subscriber = session.declare_subscriber(_KEY, lambda got: read(got.payload.to_bytes()))
    threading.Event().wait()
    subscriber.undeclare()


def _sample(number: int) -> bytes:
    return sample_bytes(sample(number))


def ask(job: Job) -> None:
    page, session = job.open(), _session(job, "client")
    querier = session.declare_querier(_ASK)

    def ask_one(number: int) -> int:
        for reply in querier.get(payload=_sample(number)):
            return sample_from(reply.ok.payload.to_bytes()).number
        return -1

    ask_for(job, page, ask_one)


def answer(job: Job) -> None:
    session = _session(job, "client")

    def came(query: zenoh.Query) -> None:
        query.reply(_ASK, _sample(sample_from(query.payload.to_bytes()).number))

    queryable = session.declare_queryable(_ASK, came)
    threading.Event().wait()
    queryable.undeclare()
