"""Messages between the modules and the daemon that runs them."""

from __future__ import annotations

from dataclasses import dataclass

from hub.ipc.definition import MessageDefinition


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleInfo:
    """A module says that it lives and what it can do; also its keep-alive.

    Attributes:
        name: Name at central.
        pid: Process id on its machine.
        state: "running" or "stopping".
        capabilities: Names from `hub.gcm.capability`, separated by spaces.
        errors: Exceptions its loop has logged since it started.
    """

    name: str
    pid: int
    state: str
    capabilities: str
    errors: int


MODULE_INFO = MessageDefinition(
    name="GCM_ModuleInfo", format="{string,int,string,string,uint}", type=ModuleInfo, rate_hz=1.0
)

MESSAGES = (MODULE_INFO,)
