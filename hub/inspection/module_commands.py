"""`rune-hub modules`, `capabilities`, `start`, `stop`, `restart`, `want`, `logs`: the daemon."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterable, Sequence
from typing import TypeVar

from hub.command_output import put, put_json
from hub.errors import (
    HandlerFailedError,
    NoHandlerError,
    QueryError,
    QueryTimeoutError,
    UnknownModuleError,
)
from hub.gcm import supervision
from hub.gcm.common import COMMON_RESULT
from hub.gcm.supervision import CapabilityPhase, ModuleOrder
from hub.inspection import value_text
from hub.inspection.hub_watch import HubWatch
from hub.inspection.output import report, span, table
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.nearest import did_you_mean
from hub.plain_text import plain

T = TypeVar("T")
R = TypeVar("R")

_ANSWER_S = 2.0
_RENEW_S = supervision.LEASE_S / 3
_FOLLOW_S = 0.3
_MOST_LINES = 1000


def modules(client: Client, *, as_json: bool) -> int:
    """Show the daemon's report on each module."""
    reports = last_report(client, supervision.MODULE_REPORTS)
    if as_json:
        put_json(value_text.plain(reports))
        return 0
    rows = [
        (
            module.name,
            module.phase.name.lower(),
            _runs(module),
            module.capabilities + ("" if module.asked else " (says the file)"),
            str(module.pid or ""),
            span(module.age_s) if module.age_s else "",
            str(module.starts),
            _number(100.0 * module.processor, "%"),
            _number(module.memory_mb, " MB"),
        )
        for module in reports.modules
    ]
    heads = ("module", "phase", "runs", "capabilities", "pid", "for", "starts", "cpu", "memory")
    table(heads, rows, words=4)
    for module in reports.modules:
        if module.why:
            put(f"{module.name} {module.why}")
    return 0


def _runs(module: supervision.ModuleReport) -> str:
    """When a module runs, in words."""
    if supervision.is_console(module.capabilities.split()):
        return "visitor"
    return "always" if module.always else "on demand"


def capabilities(client: Client, *, as_json: bool) -> int:
    """Show the robot's capabilities, and the holders that want them."""
    reports = last_report(client, supervision.CAPABILITY_REPORTS)
    if as_json:
        put_json(value_text.plain(reports))
        return 0
    rows = [
        (each.name, each.phase.name.lower(), each.module, each.modules, each.wanted_by)
        for each in reports.capabilities
    ]
    heads = ("capability", "phase", "by", "modules that have it", "wanted by")
    table(heads, rows, words=5)
    return 0


def order(client: Client, module: str, wanted: str) -> int:
    """Have the daemon start, stop or restart a module."""
    command = supervision.ModuleCommand(module=module, order=ModuleOrder[wanted.upper()])
    result = ask_daemon(client, supervision.MODULE_COMMAND, command, COMMON_RESULT)
    if not result.done:
        _need_known(client, module, result.text)
    return report(result)


def want(client: Client, wanted: Sequence[str], *, seconds: float) -> int:
    """Want capabilities until Ctrl-C, or for some time (0: no limit), and report the result."""
    wants = supervision.CapabilityWants(holder=client.name, capabilities=" ".join(wanted))
    said: dict[str, str] = {}

    def show(reports: supervision.CapabilityReports, _reception: MessageInfo) -> None:
        known = {each.name: each for each in reports.capabilities}
        for name in wanted:
            now = _outlook(name, known.get(name), known)
            if said.get(name) != now:
                said[name] = now
                put(now)

    client.subscribe(supervision.CAPABILITY_REPORTS, show, last=True)
    client.every(_RENEW_S, lambda: client.publish(supervision.CAPABILITY_WANTS, wants))
    client.publish(supervision.CAPABILITY_WANTS, wants)
    end = time.monotonic() + (seconds or math.inf)
    watch = HubWatch(client)
    while time.monotonic() < end:
        watch.listen(min(0.5, end - time.monotonic()))
    known = watch.answers and bool(said)
    return 0 if known and all("is running" in text for text in said.values()) else 1


def logs(client: Client, module: str, *, lines: int, follow: bool) -> int:
    """Show the recent output of a module, and with `follow` its further output."""
    shown = _lines(client, module, 0, lines)
    _show(shown)
    if not shown.text:
        sys.stderr.write(f"rune-hub: {module} has written nothing since this hub was started\n")
    next_line = shown.next
    watch = HubWatch(client)
    while follow:
        watch.listen(_FOLLOW_S)
        try:
            shown = _lines(client, module, next_line, _MOST_LINES)
        except HandlerFailedError:
            raise
        except QueryError as error:
            # Without a daemon, a new one is starting, with counts from 0; or it is busy.
            if not client.connected or isinstance(error, NoHandlerError):
                next_line = 1
            continue
        if shown.next < next_line:  # it is another daemon, which began while we did not ask
            shown = supervision.LogLines(first=1, next=1, text="")
        _show(shown)
        next_line = shown.next
    return 0


def _show(shown: supervision.LogLines) -> None:
    sys.stdout.write(plain(shown.text, lines=True))
    sys.stdout.flush()


def _lines(client: Client, module: str, first: int, most: int) -> supervision.LogLines:
    request = supervision.LogRequest(module=module, first=first, most=min(most, _MOST_LINES))
    try:
        return ask_daemon(client, supervision.LOG_REQUEST, request, supervision.LOG_LINES)
    except HandlerFailedError as error:
        _need_known(client, module, str(error))
        raise


def _need_known(client: Client, module: str, text: str) -> None:
    """The exit code of a refusal: an unknown module is wrong usage."""
    reports = last_report(client, supervision.MODULE_REPORTS)
    if module not in (each.name for each in reports.modules):
        raise UnknownModuleError(plain(text))


def last_report(client: Client, definition: MessageDefinition[T]) -> T:
    """The newest report of the daemon.

    Raises:
        QueryError: It does not answer, or no daemon runs.
    """
    try:
        return client.last_value(definition, timeout=_ANSWER_S)
    except QueryTimeoutError:
        raise
    except QueryError as error:
        raise _no_daemon(client) from error


def ask_daemon(
    client: Client, request: MessageDefinition[T], value: T, response: MessageDefinition[R]
) -> R:
    """The daemon's answer.

    Raises:
        QueryError: It does not answer, or no daemon runs.
    """
    try:
        return client.query_response(request, value, response, timeout=_ANSWER_S)
    except NoHandlerError as error:
        raise _no_daemon(client) from error


def _no_daemon(client: Client) -> NoHandlerError:
    text = f"no daemon answers at {client.endpoint}: is it `rune-hub run` that runs there?"
    return NoHandlerError(text)


def _outlook(name: str, report: supervision.CapabilityReport | None, known: Iterable[str]) -> str:
    if report is None or not report.modules:
        near = did_you_mean(name, [each for each in known if each != name])
        lacks = f"{name}: no module of this robot has it{near}"
        return f"{lacks}; `rune-hub capabilities` shows all"
    if report.phase is CapabilityPhase.UNAVAILABLE:
        return f"{name}: {report.modules} cannot be started; see `rune-hub modules`"
    if report.phase is CapabilityPhase.RUNNING:
        return f"{name} is running: {report.module}"
    return f"{name}: {report.module} is to start"


def _number(value: float, unit: str) -> str:
    return "" if math.isnan(value) else f"{value:.0f}{unit}"
