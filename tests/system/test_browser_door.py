"""Pages in a real browser at the door for panels: none drives without the key or from elsewhere."""

from __future__ import annotations

import contextlib
import http.server
import json
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest

from hub.gcm.navigation import GROUND_TRUTH
from tests.support.foxglove_panel import DoorProcess
from tests.support.waiting import until
from tests.system.harness import HubProcess, Observer

BROWSER = shutil.which("chromium")
_PAGE_S = 60.0
_DRIVE_S = 3.0

PAGE = """<!DOCTYPE html><script>
const twist = JSON.stringify({linear: {x: 0.3, y: 0, z: 0}, angular: {x: 0, y: 0, z: 0}});
const done = words => fetch(BACK + "/done?" + new URLSearchParams({words}), {mode: "no-cors"});
const socket = new WebSocket(DOOR, ["foxglove.sdk.v1"]);
socket.onerror = () => done("refused");
socket.onopen = () => {
  socket.send(JSON.stringify({op: "advertise", channels: [
    {id: 1, topic: "/cmd_vel", encoding: "json", schemaName: "geometry_msgs/Twist"}]}));
  const frame = new Uint8Array([1, 1, 0, 0, 0, ...new TextEncoder().encode(twist)]);
  const sending = setInterval(() => socket.send(frame), 50);
  setTimeout(() => { clearInterval(sending); done("connected"); }, SECONDS * 1000);
};
</script>"""


class Site:
    """A server of pages, and the browser that opens them.

    Attributes:
        port: Of the server.
        words: What pages have said.
    """

    def __init__(self, folder: Path) -> None:
        self.words: list[str] = []
        self.page = b""
        self._folder = folder
        site = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                parts = urlsplit(self.path)
                if parts.path == "/done":
                    site.words += parse_qs(parts.query)["words"]
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(site.page if parts.path == "/" else b"")

            def log_message(self, *_: Any) -> None:
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.port = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()

    def show(self, host: str, door: str, meanwhile: Callable[[], object]) -> str:
        """Open the page of a host that connects to the door; returns what the page says.

        Args:
            host: Whose page it is; empty: a file.
            door: The address that it opens.
            meanwhile: What to do until the page says something.
        """
        self.words.clear()
        back = json.dumps(f"http://127.0.0.1:{self.port}")
        page = PAGE.replace("BACK", back).replace("DOOR", json.dumps(door))
        self.page = page.replace("SECONDS", str(_DRIVE_S)).encode()
        file = self._folder / "page.html"
        file.write_bytes(self.page)
        url = f"http://{host}:{self.port}/" if host else file.as_uri()
        profile = self._folder / f"profile-{host or 'file'}"
        assert BROWSER is not None
        command = [
            BROWSER, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
            f"--user-data-dir={profile}", "--remote-debugging-port=0",
            "--host-resolver-rules=MAP *.example 127.0.0.1", url,
        ]  # fmt: skip
        browser = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        try:
            until(
                lambda: self.words, _PAGE_S, f"the page of {url} says nothing", meanwhile=meanwhile
            )
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(browser.pid, signal.SIGKILL)
            browser.wait()
        return self.words[0]


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with closing(Site(tmp_path)) as made:
        yield made


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.skipif(BROWSER is None, reason="NOT TESTED: chromium is missing (apt-get install it)")
def test_pages_drive_only_with_the_key_and_from_this_machine(
    start_hub: Callable[..., HubProcess], site: Site, stack: ExitStack
) -> None:
    hub = start_hub(modules=("driver", "navigation"))
    door = stack.enter_context(closing(DoorProcess(hub.endpoint, "--drive")))
    observer = stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH)))
    bare, port = door.address.rpartition("/")[0], urlsplit(door.address).port
    path = urlsplit(door.address).path

    def moved(host: str, address: str) -> tuple[str, bool]:
        observer.history.clear()
        words = site.show(host, address, lambda: observer.client.listen(0.02))
        fastest = max(abs(truth.commanded_linear) for _, truth in observer.history)
        return words, fastest > 0.02

    assert moved("evil.example", f"{bare}/") == ("refused", False)
    assert moved("", f"{bare}/") == ("refused", False)
    assert moved("127.0.0.1", bare) == ("refused", False)
    assert moved("evil.example", door.address) == ("refused", False), "with the key, from elsewhere"
    assert moved("evil.example", f"ws://rebound.example:{port}{path}") == ("refused", False)
    assert moved("127.0.0.1", f"ws://rebound.example:{port}{path}") == ("refused", False)
    assert moved("", door.address) == ("refused", False), "a browser calls files null"
    assert moved("127.0.0.1", door.address) == ("connected", True), "a page of this machine"
