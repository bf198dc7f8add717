"""The systemd unit of a robot's hub, for one machine."""

from __future__ import annotations

import grp
import pwd
import re
import string
import sys
from collections.abc import Sequence
from pathlib import Path

from hub.errors import HubError
from hub.ipc.transport import file_descriptors
from hub.robomon.module_table import RobotTable
from hub.values import dataclass

_UNIT = string.Template("""\
# Runs the hub of $robot. Written by `rune-hub service`; to change it, write it again, or run
#     systemctl edit rune-hub
# Install:   rune-hub service $robot_argument > /etc/systemd/system/rune-hub.service
#            systemctl daemon-reload && systemctl enable --now rune-hub
# Look:      systemctl status rune-hub; journalctl -u rune-hub -f
# Keys:      $keys

[Unit]
Description=Rune hub of $description
$network
# A robot that stands in the field is never given up.
StartLimitIntervalSec=0

[Service]
Type=notify
NotifyAccess=main
ExecStart=$command
User=$user$groups
Restart=on-failure
RestartSec=2
TimeoutStartSec=60
# The daemon says that it lives; when it hangs, it is ended and started again.
WatchdogSec=10
# Only the daemon is asked to stop: it ends the modules in order, the driver last. What is left
# after the time that a module may take is killed.
KillMode=mixed
TimeoutStopSec=$stop_timeout
# Sockets of the modules; a folder of its own, so that nothing of a killed hub stays behind.
RuntimeDirectory=%N
RuntimeDirectoryMode=0700
Environment=XDG_RUNTIME_DIR=%t/%N
LogsDirectory=%N
StateDirectory=%N
LimitNOFILE=$descriptors$nice
UMask=0077

# What a hub never does. Devices stay open to it, within the rights of user and groups: neither
# PrivateDevices nor ProtectClock, which closes all devices but the clock's as well.
NoNewPrivileges=yes
CapabilityBoundingSet=
ProtectSystem=full$writable
PrivateTmp=yes
ProtectControlGroups=yes
ProtectHostname=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
RestrictNamespaces=yes
RestrictSUIDSGID=yes
LockPersonality=yes
SystemCallArchitectures=native
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK AF_CAN AF_BLUETOOTH

[Install]
WantedBy=multi-user.target
""")

_ONLINE = "Wants=network-online.target\nAfter=network-online.target"
DEVICE_GROUPS = ("video", "dialout", "input", "plugdev", "gpio", "i2c", "spi")
"""Groups to which systems give cameras, serial ports, HID devices and buses."""
_ENDING_S = 5.0
"""Time for the daemon's own end, besides its modules [s]."""
_CONTROL = dict.fromkeys((*range(32), 127, 133, 8232, 8233), " ")
_USER = re.compile(r"[A-Za-z_][A-Za-z0-9_-]{0,30}", re.ASCII)


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceSpec:
    """The values of a unit.

    Attributes:
        robot: The robot's name.
        robot_file: The robot file, an absolute path.
        robot_argument: The file's name on the command line.
        command: The command of `rune-hub`, an absolute path first.
        user: User of the hub.
        groups: Groups of devices that exist on this machine.
        keys: Folder of the keys; None for the one in the user's home.
        writable: Folders that the hub writes to.
        gateway: Whether it listens on the network, and so waits for it.
        nice: Lowest niceness of its modules; at most 0.
        stop_timeout: Longest time that one of its modules may take to stop [s].
    """

    robot: str
    robot_file: Path
    robot_argument: str
    command: Sequence[str]
    user: str
    groups: Sequence[str]
    keys: Path | None
    writable: Sequence[Path]
    gateway: bool
    nice: int
    stop_timeout: float


def unit(spec: ServiceSpec) -> str:
    """The text of the unit."""
    hub = " ".join(spec.command)
    words = [*spec.command, "run", str(spec.robot_file)]
    folder = "" if spec.keys is None else f" --folder {spec.keys}"
    writable = " ".join(_word(f"-{path}") for path in spec.writable)
    return _UNIT.substitute(
        robot=_plain(spec.robot),
        robot_argument=_plain(spec.robot_argument),
        keys=_plain(f"sudo -u {spec.user} {hub} keys make NAME --role operate{folder}"),
        description=_plain(spec.robot).replace("%", "%%"),
        network=_ONLINE if spec.gateway else "After=network.target",
        command=" ".join(_word(word).replace("$", "$$") for word in words),
        descriptors=file_descriptors.WANTED,
        nice=f"\nLimitNICE={spec.nice}" if spec.nice < 0 else "",
        user=spec.user,
        groups=f"\nSupplementaryGroups={' '.join(spec.groups)}" if spec.groups else "",
        stop_timeout=f"{spec.stop_timeout + _ENDING_S:g}",
        writable=f"\nReadWritePaths={writable}" if writable else "",
    )


def for_this_machine(table: RobotTable, argument: str, user: str) -> ServiceSpec:
    """The values of the unit on this machine.

    Args:
        table: The robot.
        argument: Its file's name on the command line.
        user: User of the hub.

    Raises:
        HubError: This is no valid user name.
    """
    if not _USER.fullmatch(user):
        text = f"{user[:80]!r} is no name that a user can have"
        raise HubError(text)
    program = Path(sys.executable).with_name("rune-hub")
    known = {group.gr_name for group in grp.getgrall()}
    robot = table.robot
    folders = (robot.keys, robot.logs, robot.map_folder, robot.mission_folder)
    written = [folder for folder in folders if folder]
    return ServiceSpec(
        robot=robot.name,
        robot_file=robot.path.resolve(),
        robot_argument=argument,
        command=(str(program),) if program.is_file() else (sys.executable, "-m", "hub"),
        user=user,
        groups=tuple(name for name in DEVICE_GROUPS if name in known),
        keys=Path(robot.keys).absolute() if robot.keys else None,
        writable=tuple(Path(folder).absolute() for folder in written),
        gateway=bool(robot.gateway),
        nice=min(0, *(module.nice for module in table.modules)),
        stop_timeout=max(module.stop_timeout_s for module in table.modules),
    )


def write_unit(table: RobotTable, argument: str, user: str) -> int:
    """Print the unit, and its other needs on standard error; returns the exit code.

    Raises:
        HubError: This is no valid user name.
    """
    sys.stdout.write(unit(for_this_machine(table, argument, user)))
    try:
        pwd.getpwnam(user)
    except KeyError:
        sys.stderr.write(
            f"rune-hub: there is no user {user} yet; make it with: "
            f"useradd --system --create-home {user}, or name another one with --user\n"
        )
    return 0


def _word(text: str) -> str:
    """A word by systemd.syntax(7): quoted if needed, % doubled."""
    text = _plain(text, backslash="\\\\").replace('"', '\\"').replace("%", "%%")
    return f'"{text}"' if any(c in text for c in " \"'\\;") else text


def _plain(text: str, *, backslash: str = "/") -> str:
    """The text without characters that start another line or join the next one."""
    return text.translate(_CONTROL).replace("\\", backslash)
