"""A lost hub is a drawn state, and the console comes back by itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.system.harness import ConsoleProcess, HubProcess, Observer


def test_console_without_a_hub_says_so_and_goes_on(
    start_console: Callable[..., ConsoleProcess],
) -> None:
    console = start_console("tcp://127.0.0.1:1")
    console.wait(lambda: "no link" in console.text or "connecting" in console.text, 10.0)
    assert console.quit() == 0


def test_console_comes_back_when_the_hub_does(
    tmp_path: Path, start_console: Callable[..., ConsoleProcess]
) -> None:
    first = HubProcess(tmp_path, name="again")
    console = start_console(first.endpoint)
    console.wait_for_picture()
    first.close()
    console.wait(lambda: "LINK LOST" in console.text, 10.0)
    second = HubProcess(tmp_path, name="again")
    try:
        console.wait(lambda: "LINK LOST" not in console.text, 15.0)
        console.wait_for_picture()
        observer = Observer(second.endpoint)
        console.hold_until("w", lambda: observer.truth.linear > 0.1)
        observer.close()
    finally:
        second.close()
