"""Real hubs, observers and consoles, ended after each test."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from tests.support.fake_hid import VirtualBed
from tests.system.harness import ConsoleProcess, HubProcess, Observer

LAYOUT = """<rune run="1">
  <robot name="magellan" hub="{hub}">
    <capability name="VIS_VID" interval_ms="500"/>
    <capability name="VIS_PTZ"/>
    <capability name="NAV_STATE"/>
    <capability name="NAV_MOVE"/>
  </robot>
  <view xsize="100" ysize="60">
    <widget handler="widgetQuit"><event key="q"/></widget>
    <viewport name="camera" robot="magellan" xpos="0" ypos="0" xsize="100" ysize="58">
      <visualizer function="visualizeCameraImage" message="GCM_Common_Image"/>
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate" value="1"/>
        <event key="s" control="translate" value="-1"/>
        <event key="a" control="rotate" value="1"/>
        <event key="d" control="rotate" value="-1"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetAdjustPan"><event key="j" value="1"/></widget>
    </viewport>
    <viewport name="status" robot="magellan" xpos="0" ypos="58" xsize="100" ysize="2">
      <visualizer function="visualizeStatus" message="GCM_RobotState"/>
    </viewport>
  </view>
</rune>
"""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """The report of a failed test shows the logs of the hubs that still run."""
    report = yield
    if report.failed:
        logs = ((f"log of {hub.endpoint}", hub.log.read_text()) for hub in HubProcess.running)
        report.sections.extend(logs)
    return report


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    """Closes everything, the last opened first."""
    with ExitStack() as opened:
        yield opened


@pytest.fixture
def start_hub(tmp_path: Path, stack: ExitStack) -> Callable[..., HubProcess]:
    """Start a hub with a simulated robot in an empty hall."""

    def start(**options: Any) -> HubProcess:
        return stack.enter_context(closing(HubProcess(tmp_path, **options)))

    return start


@pytest.fixture
def hub(start_hub: Callable[..., HubProcess]) -> HubProcess:
    return start_hub()


@pytest.fixture(scope="module")
def lasting_hub(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[HubProcess]:
    """A hub for the tests of a file that leave its processes alone, with the options in `HUB`."""
    folder = tmp_path_factory.mktemp("hub")
    with pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        patch.setenv("XDG_STATE_HOME", str(folder))
        hub = HubProcess(folder, **getattr(request.module, "HUB", {}))
        stack.enter_context(closing(hub))
        yield hub


@pytest.fixture(scope="module")
def bed() -> Iterator[VirtualBed]:
    """A machine's joysticks."""
    with closing(VirtualBed()) as opened:
        yield opened


@pytest.fixture
def observer(hub: HubProcess, stack: ExitStack) -> Observer:
    """Sees ground truth."""
    return stack.enter_context(closing(Observer(hub.endpoint)))


@pytest.fixture
def start_console(tmp_path: Path, stack: ExitStack) -> Callable[..., ConsoleProcess]:
    """Start a console with the tests' layout on a hub."""

    def start(hub_endpoint: str, **options: Any) -> ConsoleProcess:
        return stack.enter_context(closing(console_of(hub_endpoint, tmp_path, **options)))

    return start


def console_of(hub_endpoint: str, folder: Path, **options: Any) -> ConsoleProcess:
    """A console with the tests' layout."""
    layout = folder / "layout.xml"
    layout.write_text(LAYOUT.format(hub=hub_endpoint))
    return ConsoleProcess(["run", str(layout)], **options)


@pytest.fixture
def console(hub: HubProcess, start_console: Callable[..., ConsoleProcess]) -> ConsoleProcess:
    """A console that shows the picture of a robot that is ready to drive."""
    started = start_console(hub.endpoint)
    started.wait_for_picture()
    started.wait(lambda: "STANDING" in started.text, 10.0)
    return started
