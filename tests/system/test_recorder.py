"""The robot's recorder and `rune-hub record`: real hubs, processes, files, and SIGKILL."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.recording import (
    RECORD_COMMAND,
    RECORD_MARK,
    RECORD_STATE,
    RecordAction,
    RecordCommand,
    RecordState,
)
from hub.ipc.definition import MessageDefinition
from hub.recording.reader import Recording
from hub.recording.records import MAGIC
from hub.values import dataclass
from tests.support.command_line import rune_hub
from tests.support.waiting import exit_code
from tests.system.harness import ConsoleProcess, HubProcess, Observer

RECORDER = """
[modules.recorder]
run = "hub.modules.recorder"
[recording]
folder = "recordings"
least_free = "1 MB"
pictures = {{ rate = 0 }}
{keys}
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Count:
    """A message of a module that nobody knew before."""

    value: int = 0
    text: str = ""


COUNT = MessageDefinition(name="TEST_Count", type=Count)


def recorder(keys: str = "") -> dict[str, Any]:
    """Keys of a hub whose only modules are the driver and the recorder."""
    return {"modules": ("driver",), "tables": RECORDER.format(keys=keys)}


def state_of(observer: Observer) -> RecordState:
    state: RecordState = observer.seen[RECORD_STATE.name][-1][1]
    return state


def ask(observer: Observer, **order: Any) -> CommonResult:
    return observer.client.query_response(
        RECORD_COMMAND, RecordCommand(**order), COMMON_RESULT, timeout=10.0
    )


def contents(path: Path) -> list[tuple[str, int, bytes]]:
    """Topic, number and payload of each message of a file; of one that just begins, none."""
    if path.stat().st_size < len(MAGIC):
        return []
    with Recording.open(path) as recording:
        return [
            (recording.channels[each.channel].name, each.number, each.payload)
            for each in recording.messages()
        ]


def counts(paths: list[Path]) -> list[int]:
    """The values of the counted messages in files."""
    return [
        COUNT.decode(payload).value
        for path in paths
        for topic, _, payload in contents(path)
        if topic == "/magellan/TEST_Count"
    ]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "recordings" / "magellan"


@pytest.fixture
def look(stack: ExitStack) -> Callable[..., Observer]:
    """Observers of a hub."""

    def make(hub: HubProcess, *definitions: MessageDefinition[Any]) -> Observer:
        return stack.enter_context(closing(Observer(hub.endpoint, *definitions)))

    return make


Start = Callable[..., HubProcess]
Look = Callable[..., Observer]


def test_orders_begin_split_mark_and_end_a_recording(
    start_hub: Start, look: Look, folder: Path
) -> None:
    observer = look(start_hub(**recorder()), RECORD_STATE)
    assert "nothing is recorded" in ask(observer, action=RecordAction.MARK).text
    assert ask(observer, action=RecordAction.STOP).done == 0
    begun = ask(observer, action=RecordAction.START, name="trial 7", by="Ada")
    assert begun.text == f"records to {folder / 'trial-7.mcap'}"
    assert ask(observer, action=RecordAction.START).done == 0
    observer.wait(lambda: state_of(observer).recording, 10.0)
    assert state_of(observer).by == "Ada"
    observer.wait(lambda: state_of(observer).messages > 20, 20.0)
    assert ask(observer, action=RecordAction.MARK, text="a victim").done
    observer.wait(lambda: state_of(observer).mark == "a victim", 10.0)
    assert ask(observer, action=RecordAction.SPLIT).done
    observer.wait(lambda: state_of(observer).files == 2, 10.0)
    observer.client.publish(COUNT, Count(value=1, text="later"))
    observer.client.wait_published(5.0)
    files = [folder / "trial-7.mcap", folder / "trial-7_1.mcap"]

    def reported() -> bool:
        """Publish until the recorder has subscribed to what it did not know before."""
        observer.client.publish(COUNT, Count(value=2))
        return len(set(counts(files[1:]))) > 0

    observer.wait(reported, 20.0)
    assert "messages" in ask(observer, action=RecordAction.STOP).text
    observer.wait(lambda: not state_of(observer).recording, 10.0)
    assert state_of(observer).lost == 0
    topics = [{topic for topic, _, _ in contents(path)} for path in files]
    assert {"/magellan/SIM_GroundTruth", "/magellan/GCM_DriveState"} <= topics[0] & topics[1]
    assert "/magellan/GCM_RobotDescription" in topics[1], "each file is complete by itself"
    read = [each for path in files for each in contents(path)]
    marks = [payload for topic, _, payload in read if topic.endswith("Record_Mark")]
    assert [RECORD_MARK.decode(each).text for each in marks] == ["a victim"]
    with Recording.open(files[1]) as recording:
        assert [each.name for each in recording.attachments] == ["robot.toml"]
        assert recording.finished


def test_a_killed_recorder_loses_half_a_second_and_goes_on_in_another_file(
    start_hub: Start, look: Look, folder: Path
) -> None:
    hub = start_hub(**recorder('keep = "1h"\nalways = true'))
    observer = look(hub, RECORD_STATE)
    ring = folder / "ring"
    sent = [0]
    written: list[float] = []

    def publish() -> None:
        sent[0] += 1
        observer.client.publish(COUNT, Count(value=sent[0]))
        written.append(time.monotonic())

    observer.client.every(0.01, publish)
    observer.wait(lambda: counts(sorted(ring.glob("*.mcap"))), 20.0)
    observer.wait(lambda: sent[0] >= 400, 30.0)
    first = sorted(ring.glob("*.mcap"))
    os.kill(hub.pids["recorder"], signal.SIGKILL)
    killed, at = sent[0], time.monotonic()
    kept = counts(first)
    assert kept == list(range(kept[0], kept[-1] + 1))
    lost_s = at - written[kept[-1] - 1] if kept[-1] < killed else 0.0
    # Half a second, and what a busy machine adds: its writer may wait for a processor.
    assert lost_s <= 1.5, f"{killed - kept[-1]} messages in {lost_s:.2f} s"

    def others() -> list[Path]:
        return [path for path in sorted(ring.glob("*.mcap")) if path not in first]

    observer.wait(lambda: others() and counts(others()), 20.0)
    topics = {topic for topic, _, _ in contents(others()[0])}
    assert "/magellan/GCM_RobotDescription" in topics
    observer.wait(lambda: state_of(observer).ring_s > (at - written[0]) / 2, 20.0)


def test_a_snapshot_is_a_file_of_its_own(start_hub: Start, look: Look, folder: Path) -> None:
    observer = look(start_hub(**recorder('keep = "1h"\nalways = true')), RECORD_STATE)
    sent = [0]

    def publish() -> None:
        sent[0] += 1
        observer.client.publish(COUNT, Count(value=sent[0]))

    observer.client.every(0.02, publish)
    observer.wait(lambda: counts(sorted((folder / "ring").glob("*.mcap"))), 20.0)
    observer.wait(lambda: state_of(observer).ring_s > 3.0, 20.0)
    before = sent[0]
    order = {"text": "bump", "name": "bump", "before_s": 1.0, "after_s": 0.5}
    assert ask(observer, action=RecordAction.SNAPSHOT, **order).done
    target = folder / "snapshots" / "bump.mcap"
    observer.wait(target.exists, 30.0)
    found = counts([target])
    assert found[0] < before - 10
    assert found[-1] > before + 10
    assert found == list(range(found[0], found[-1] + 1))
    with Recording.open(target) as recording:
        assert 1.0 <= (recording.end - recording.start) / 1e9 <= 1.6
    topics = {topic for topic, _, _ in contents(target)}
    assert {"/magellan/GCM_RobotDescription", "/magellan/GCM_Record_Mark"} <= topics
    observer.wait(lambda: not target.with_suffix(".parts").exists(), 10.0)


@pytest.mark.soak
def test_a_snapshot_outlives_its_recorder(start_hub: Start, look: Look, folder: Path) -> None:
    hub = start_hub(**recorder('keep = "1h"\nalways = true'))
    observer = look(hub, RECORD_STATE)
    observer.wait(lambda: state_of(observer).ring_s > 2.0, 20.0)
    order = {"text": "bump", "name": "bump", "before_s": 1.5, "after_s": 4.0}
    assert ask(observer, action=RecordAction.SNAPSHOT, **order).done
    asked = time.time()
    observer.wait(lambda: time.time() > asked + 1.0, 10.0)
    os.kill(hub.pids["recorder"], signal.SIGKILL)
    target = folder / "snapshots" / "bump.mcap"
    observer.wait(target.exists, 30.0)
    with Recording.open(target) as recording:
        assert recording.finished
        assert recording.start / 1e9 < asked - 1.0
        assert recording.end / 1e9 > asked + 3.0
    observer.wait(lambda: "it lacks" in state_of(observer).fault, 10.0)
    observer.wait(lambda: not target.with_suffix(".parts").exists(), 10.0)


def test_a_recording_that_an_order_began_outlives_its_recorder(
    start_hub: Start, look: Look, folder: Path
) -> None:
    hub = start_hub(**recorder())
    observer = look(hub, RECORD_STATE)
    assert ask(observer, action=RecordAction.START, name="long").done
    observer.wait(lambda: state_of(observer).messages > 10, 20.0)
    os.kill(hub.pids["recorder"], signal.SIGKILL)
    second = folder / "long_1.mcap"
    observer.wait(second.exists, 20.0)
    observer.wait(lambda: state_of(observer).path == str(second), 20.0)
    observer.wait(lambda: state_of(observer).messages > 0, 20.0)
    assert ask(observer, action=RecordAction.STOP).done
    assert contents(folder / "long.mcap")
    assert contents(second)
    assert not (folder / "running.json").exists()


def test_what_a_full_disk_does_not_keep_is_not_said_to_be_kept(
    start_hub: Start, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # else caches of modules would be cut
    hub = start_hub(**recorder())
    observer = look(hub, RECORD_STATE)
    assert ask(observer, action=RecordAction.START).done
    observer.wait(lambda: state_of(observer).messages > 10, 20.0)
    assert ask(observer, action=RecordAction.MARK, text="before").text == "mark 1 is kept: before"
    # From here on no file of the recorder may grow, as on a full disk.
    pid = hub.pids["recorder"]
    usual = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (1, usual[1]))
    marked = ask(observer, action=RecordAction.MARK, text="after")
    assert (marked.done, "mark 2 is not kept: " in marked.text) == (0, True), marked.text
    observer.wait(lambda: state_of(observer).fault and state_of(observer).lost, 20.0)
    assert state_of(observer).marks == 1
    for action in (RecordAction.SNAPSHOT, RecordAction.SPLIT):
        assert ask(observer, action=action).done == 0
    said = rune_hub("status", "--hub", hub.endpoint)
    assert (said.returncode, "recording: " in said.stdout) == (1, True)
    done = rune_hub("record", "--hub", hub.endpoint, "--stop")
    assert done.returncode == 1
    assert "the recording is ended, and lacks " in done.stderr
    assert "cannot be made: File too large" in done.stderr
    assert state_of(observer).lost > 0, "those of the last recording"
    resource.prlimit(pid, resource.RLIMIT_FSIZE, usual)
    assert ask(observer, action=RecordAction.START, name="next").done
    observer.wait(lambda: state_of(observer).path.endswith("next.mcap"), 20.0)
    assert (state_of(observer).lost, state_of(observer).lost_by_topic) == (0, ())


def command(hub: HubProcess, *arguments: str) -> subprocess.Popen[str]:
    """`rune-hub record`, until it says that it records."""
    process = subprocess.Popen(
        [sys.executable, "-m", "hub", "record", "--hub", hub.endpoint, "--json", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    said = process.stdout.readline()
    assert said, process.communicate()[1]
    assert json.loads(said)["event"] == "ready"
    return process


def test_a_recording_from_here_is_complete_after_an_interrupt(
    start_hub: Start, look: Look, tmp_path: Path
) -> None:
    hub = start_hub(modules=("driver", "vision", "navigation"))
    observer = look(hub)
    file = tmp_path / "a.mcap"
    process = command(hub, "-o", str(file), "--pictures", "10/s", "--size", "64x48")
    begun = len(observer.history)

    def complete() -> bool:
        topics = [topic for topic, _, _ in contents(file)]
        return topics.count("/magellan/GCM_Common_Image") >= 5

    observer.wait(complete, 30.0)
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate(timeout=20.0)
    assert process.returncode == 0, complained
    end = json.loads(said)
    assert end["event"] == "end"
    read = contents(file)
    assert end["messages"] == len(read)
    truths = [number for topic, number, _ in read if topic == "/magellan/SIM_GroundTruth"]
    assert truths == list(range(truths[0], truths[-1] + 1))
    assert len(truths) >= (len(observer.history) - begun) / 2
    with Recording.open(file) as recording:
        assert recording.finished


def test_topics_are_chosen_and_the_recording_ends_by_itself(
    start_hub: Start, tmp_path: Path
) -> None:
    hub = start_hub(modules=("driver",))
    file = tmp_path / "a.mcap"
    chosen = ["-e", "GCM_D", "Battery", "-x", "Diag", "--duration", "1 s", "--ros-names"]
    process = command(hub, "-o", str(file), *chosen)
    assert exit_code(process, 20.0) == 0
    process.communicate()
    topics = {topic for topic, _, _ in contents(file)}
    assert topics == {"/battery_state", "/odom", "/magellan/GCM_DriveState"}


def test_a_taken_name_and_a_missing_recorder_are_said(start_hub: Start, tmp_path: Path) -> None:
    hub = start_hub(modules=("driver",))
    file = tmp_path / "a.mcap"
    file.touch()
    for arguments, code, text in (
        (("-o", str(file)), 2, "exists already"),
        (("--least-free", "100 TiB", "-o", str(tmp_path / "b.mcap")), 2, "MB are free"),
        (("--mark", "x"), 3, "does not run"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "hub", "record", "--hub", hub.endpoint, *arguments],
            capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        assert (done.returncode, done.stderr.count(text)) == (code, 1), done.stderr


def test_too_few_open_files_are_said_in_a_sentence(start_hub: Start, tmp_path: Path) -> None:
    hub = start_hub(modules=("driver",))
    command = [sys.executable, "-m", "hub", "record", "--hub", hub.endpoint]
    done = subprocess.run(
        ["sh", "-c", 'ulimit -n 15; exec "$@"', "sh", *command, "-o", str(tmp_path / "a.mcap")],
        capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "rune-hub: the system lets this program open no more files; `ulimit -n 1024` allows more"
    ]


def test_a_hub_records_from_its_start(start_hub: Start, look: Look, tmp_path: Path) -> None:
    file = tmp_path / "trial.mcap"
    hub = start_hub(modules=("driver",), options=("--record", str(file)))
    observer = look(hub)
    observer.wait(lambda: len(observer.history) > 50, 20.0)
    seen = len(observer.history)
    hub.close()
    topics = [topic for topic, _, _ in contents(file)]
    assert topics.count("/magellan/SIM_GroundTruth") >= seen - 5
    with Recording.open(file) as recording:
        assert recording.finished


def test_a_key_of_the_console_has_the_robot_record(
    start_hub: Start, folder: Path, stack: ExitStack
) -> None:
    tables = RECORDER.format(keys="").replace(
        '"hub.modules.recorder"', '"hub.modules.recorder"\nstart = "on demand"'
    )
    hub = start_hub(modules=("driver", "navigation"), tables=tables)
    console = stack.enter_context(
        closing(ConsoleProcess(["run", "auto", "--hub", hub.endpoint], columns=140))
    )
    console.wait(lambda: "control" in console.text, 30.0, "it does not open")
    console.type("\x1b[17~")  # F6
    console.wait(lambda: "ROBOT REC" in console.text, 30.0, "the robot does not record")
    console.type("\x1b[18~")  # F7
    console.wait(lambda: "Mark this moment" in console.text, 10.0, "it does not ask")
    console.type("bump")
    console.wait(lambda: "bump" in console.text, 10.0, "it takes no text")
    console.pump(0.5)  # letters that come at once are a paste, and Enter counts after it
    console.type("\r")
    console.wait(lambda: "mark 1 is in the recording" in console.text, 20.0, "no mark")
    console.type("\x1b[17~")
    console.wait(lambda: "ROBOT REC" not in console.text, 20.0, "it does not end")
    assert console.quit() == 0
    (file,) = folder.glob("*.mcap")
    marks = [payload for topic, _, payload in contents(file) if topic.endswith("Record_Mark")]
    assert [RECORD_MARK.decode(each).text for each in marks] == ["bump"]


def test_a_recorder_without_a_folder_says_so(start_hub: Start, look: Look) -> None:
    keys = recorder('always = true\nfolder = "/dev/null"')
    keys["tables"] = keys["tables"].replace('folder = "recordings"\n', "")
    hub = start_hub(**keys)
    observer = look(hub, RECORD_STATE)
    fault = "nothing is recorded: /dev/null/magellan cannot be made: Not a directory; "
    observer.wait(lambda: state_of(observer).fault.startswith(fault), 10.0)
