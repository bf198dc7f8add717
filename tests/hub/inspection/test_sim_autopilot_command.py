"""`rune-hub sim-autopilot` serves stations over TCP, UDP and a pseudo terminal."""

import contextlib
import json
import socket
import subprocess
import sys
import time

import pytest

from hub.robots.mavlink.link.address import vehicle_address
from hub.robots.mavlink.link.opening import link_to
from hub.robots.mavlink.wire.frames import FrameParser
from tests.support.command_line import rune_hub
from tests.support.waiting import until


@contextlib.contextmanager
def simulated_autopilot(*arguments):
    """Its addresses, while it runs."""
    command = [sys.executable, "-m", "hub", "sim-autopilot", *arguments, "--json"]
    with subprocess.Popen(
        [*command, "--stop-with-stdin"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        try:
            yield json.loads(process.stdout.readline())["addresses"]
        finally:
            process.stdin.close()
            assert process.wait(10.0) == 0


def heard(link, parser):
    """Names of the messages that come next."""
    find = parser.datagram if link.datagrams else parser.feed
    return {frame.name for data in link.read(time.monotonic()) for frame in find(data)}


def test_it_serves_all_links_at_once():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        free = probe.getsockname()[1]
    with simulated_autopilot(
        "sub", "--tcp", "0", "--pty", "--udp", f"127.0.0.1:{free}", "--fast-boot"
    ) as (tcp, udp, pty):
        addresses = [tcp, tcp, pty, udp.replace("127.0.0.1", "")]
        with contextlib.ExitStack() as stack:
            for text in addresses:
                link = link_to(vehicle_address(text))
                stack.callback(link.close)
                parser = FrameParser()
                names: set[str] = set()
                until(
                    lambda link=link, parser=parser, names=names: (
                        names.update(heard(link, parser)) or {"HEARTBEAT", "ATTITUDE"} <= names
                    ),
                    10.0,
                    f"no heartbeat by {text}",
                )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["boat"], "boat"),
        (["rover", "--parameters", "FS_TIMEOUTS=1"], "FS_TIMEOUT"),
        (["rover", "--parameters", "FS_TIMEOUT=much"], "NAME=VALUE"),
        (["rover", "--udp", "14550"], "HOST:PORT"),
        (["rover", "--tcp", "70000"], "65535"),
    ],
)
def test_wrong_usage_is_said_in_a_sentence(arguments, said):
    ended = rune_hub("sim-autopilot", *arguments)
    assert ended.returncode == 2
    assert said in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
