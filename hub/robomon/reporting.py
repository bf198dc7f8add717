"""The daemon on the bus: reports and wants of modules and consoles, and its own reports."""

from __future__ import annotations

import time

from hub.errors import HandlerFailedError
from hub.gcm import supervision
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.common import (
    COMMON_COMMAND,
    COMMON_RESULT,
    CommonCommand,
    CommonCommandKind,
    CommonResult,
)
from hub.gcm.supervision import ModulePhase
from hub.gcm.transforms import STATIC_TRANSFORMS, static_transforms
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.wire.control import Change, Presence
from hub.robomon.module_lifecycle import ModuleLifecycle
from hub.robomon.module_logs import REMEMBERED_LINES, ModuleLogs
from hub.robomon.process_supervisor import BY_ROBOMON, ProcessSupervisor
from hub.runtime import publish_on_request

_MOST_TEXT = 262_144
"""Most characters of log lines in one answer."""


class Reporting:
    """Connects the policy with the bus."""

    def __init__(
        self, client: Client, supervisor: ProcessSupervisor, outputs: ModuleLogs, body: RobotBody
    ) -> None:
        self._client = client
        self._supervisor = supervisor
        self._policy = supervisor.policy
        self._outputs = outputs
        self._robot = body.name
        self._clock = time.monotonic
        client.define(supervision.MODULE_REPORTS, supervision.CAPABILITY_REPORTS, COMMON_COMMAND)
        # Central keeps both for later subscribers.
        client.publish(ROBOT_DESCRIPTION, body)
        client.publish(STATIC_TRANSFORMS, static_transforms(body))
        client.subscribe(supervision.MODULE_INFO, self._announced)
        client.subscribe(supervision.CAPABILITY_WANTS, self._wanted)
        client.subscribe(COMMON_COMMAND, self._commanded)
        client.respond(supervision.MODULE_COMMAND, COMMON_RESULT, self._ordered)
        client.respond(supervision.LOG_REQUEST, supervision.LOG_LINES, self._lines)
        client.directory.watch(self._presence)
        publish_on_request(client, supervision.MODULE_REPORTS, self._publish_modules)
        publish_on_request(client, supervision.CAPABILITY_REPORTS, self._publish_capabilities)
        client.every(1.0 / supervision.MODULE_REPORTS.rate_hz, self.publish)

    def publish(self) -> None:
        """Publish the state of modules and capabilities."""
        self._publish_modules()
        self._publish_capabilities()

    def _announced(self, info: supervision.ModuleInfo, _reception: MessageInfo) -> None:
        self._policy.announced(
            info.name, info.pid, info.capabilities.split(), info.needs.split(), self._clock()
        )
        self._supervisor.step()

    def _wanted(self, wants: supervision.CapabilityWants, reception: MessageInfo) -> None:
        capabilities = wants.capabilities.split()
        now = self._clock()
        self._policy.wants.renew(
            reception.publisher, wants.holder, capabilities, now, lease_s=wants.lease_s
        )
        self._supervisor.step()

    def _commanded(self, command: CommonCommand, _reception: MessageInfo) -> None:
        """Note a direct order to modules; their ends and starts are then intended."""
        if command.argument == BY_ROBOMON:
            return
        for name, lifecycle in self._policy.lifecycles.items():
            if command.module in ("", name):
                if command.command is CommonCommandKind.STOP:
                    lifecycle.stop_by_order(self._clock())
                elif command.command is CommonCommandKind.START:
                    lifecycle.start_by_order()
        self._supervisor.step()

    def _ordered(self, command: supervision.ModuleCommand) -> CommonResult:
        done, text = self._policy.ordered(command.module, command.order, self._clock())
        self._supervisor.step()
        return CommonResult(done=int(done), text=text)

    def _lines(self, request: supervision.LogRequest) -> supervision.LogLines:
        if request.module not in self._policy.lifecycles:
            raise HandlerFailedError(self._policy.unknown(request.module))
        most = max(0, min(request.most, REMEMBERED_LINES))
        first, lines = self._outputs.recent(request.module, request.first, most)
        room, taken = _MOST_TEXT, 0
        for line in lines:
            room -= len(line)
            if room < 0:
                break
            taken += 1
        text = "".join(lines[:taken])
        return supervision.LogLines(first=first, next=first + taken, text=text)

    def _presence(self, presence: Presence) -> None:
        if presence.change is Change.DISCONNECTED:
            self._policy.wants.disconnected(presence.module)

    def _publish_modules(self) -> None:
        lifecycles = self._policy.lifecycles
        now = self._clock()
        reports = [self._report(name, lifecycle, now) for name, lifecycle in lifecycles.items()]
        reports += [
            supervision.ModuleReport(
                name=name,
                phase=ModulePhase.RUNNING,
                pid=external.pid,
                capabilities=" ".join(sorted(external.provides)),
                needs=" ".join(sorted(external.needs)),
                asked=1,
                always=0,
                starts=0,
                processor=float("nan"),
                memory_mb=float("nan"),
                age_s=0.0,
                why="is a console, a visitor"
                if supervision.is_console(external.provides)
                else "was started by another program",
            )
            for name, external in self._policy.externals.items()
            if name not in lifecycles
        ]
        self._client.publish(
            supervision.MODULE_REPORTS,
            supervision.ModuleReports(robot=self._robot, modules=tuple(reports)),
        )

    def _report(
        self, name: str, lifecycle: ModuleLifecycle, now: float
    ) -> supervision.ModuleReport:
        return supervision.ModuleReport(
            name=name,
            phase=lifecycle.phase,
            pid=lifecycle.pid,
            capabilities=" ".join(sorted(lifecycle.provides)),
            needs=" ".join(sorted(lifecycle.needs)),
            asked=int(lifecycle.asked),
            always=int(lifecycle.spec.always),
            starts=lifecycle.starts,
            processor=self._supervisor.processor(name),
            memory_mb=self._supervisor.memory_mb(name),
            age_s=now - lifecycle.since if lifecycle.has_process else 0.0,
            why="; it ".join(filter(None, (lifecycle.why, self._outputs.fault(name)))),
        )

    def _publish_capabilities(self) -> None:
        reports = tuple(self._policy.capabilities(self._clock()).values())
        self._client.publish(
            supervision.CAPABILITY_REPORTS,
            supervision.CapabilityReports(
                robot=self._robot,
                capabilities=reports,
                undeclared=self._policy.undeclared,
            ),
        )
