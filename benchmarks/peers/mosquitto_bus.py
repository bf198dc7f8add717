"""MQTT: Mosquitto, and the Paho client, at most once."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import paho.mqtt.client as mqtt

from benchmarks.peers.job import Job, counter, drive, maker, reader

_TOPIC = "bench/t"
_SETTINGS = """listener {port} 127.0.0.1
allow_anonymous true
max_queued_messages 10000
set_tcp_nodelay true
persistence false
"""


def broker(job: Job) -> None:
    program = shutil.which("mosquitto", path=os.environ["PATH"] + ":/usr/sbin") or "mosquitto"
    settings = Path(job.page + ".conf")
    settings.write_text(_SETTINGS.format(port=job.port))
    os.execv(program, [program, "-c", str(settings)])


def _client(job: Job) -> mqtt.Client:
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    client.max_queued_messages_set(0)
    client.connect("127.0.0.1", job.port)
    return client


def send(job: Job) -> None:
    page, client, make = job.open(), _client(job), maker(job)
    client.loop_start()
    drive(job, page, lambda number: client.publish(_TOPIC, make(number), 0))


def receive(job: Job) -> None:
    read, client = reader(job.size, counter(job)), _client(job)
    client.on_message = lambda _client, _data, message: read(message.payload)
    client.subscribe(_TOPIC, 0)
    client.loop_forever()
