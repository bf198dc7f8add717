"""The doctor on this machine: the needs of any hub."""

from __future__ import annotations

import os
import platform
import pwd
import re
import resource
import shlex
import shutil
import time
from pathlib import Path

from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.inspection.doctor.robot_checks import existing, written_folders
from hub.ipc.transport import file_descriptors, shared_ring
from hub.robots.description import RobotDescription

_FEWEST_DESCRIPTORS = 256
_LEAST_MEMORY, _GOOD_MEMORY = 200 << 20, 500 << 20
_LEAST_SPACE, _GOOD_SPACE = 50 << 20, 1 << 30
_COARSEST_CLOCK_S = 1e-3
_BUSY = 1.5
_AVAILABLE = re.compile(r"^MemAvailable:\s+(\d+) kB$", re.MULTILINE)
SYSTEMD = Path("/run/systemd/system")
_UNITS = Path("/etc/systemd/system")
_LINGERING = Path("/var/lib/systemd/linger")


def user(robot_file: str) -> list[Finding]:
    """The user of the doctor: it can check only what this user may read."""
    name = user_name()
    if os.geteuid() == 0:
        text = "all this was looked at as root, to whom everything is open"
        command = f"sudo -u rune rune-hub doctor {shlex.quote(robot_file)}"
        return [warning(text, f"look as the user of the hub: {command}")]
    return [ok(f"all this holds for {name}")]


def shared_memory() -> list[Finding]:
    """Whether modules can hand each other pictures without copying them through sockets."""
    slower = "nothing has to be done; pictures go through sockets, which takes more time"
    if not shared_ring.available:
        return [warning("this system has no memfd_create", slower)]
    said = b"a picture"
    try:
        writer = shared_ring.RingWriter(4096)
        try:
            place = writer.write([said])
            reader = shared_ring.RingReader(place)
            try:
                read = reader.read(place)
            finally:
                reader.close()
        finally:
            writer.close()
    except OSError as fault:
        return [warning(f"it does not work here ({fault})", slower)]
    if read is None or bytes(read) != said:
        return [warning("what was written is not what is read", slower)]
    return [ok("works")]


def open_files() -> list[Finding]:
    """Whether central may have enough connections."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = file_descriptors.WANTED
    advice = f"raise it: LimitNOFILE={wanted} in the unit, or /etc/security/limits.conf"
    if most == resource.RLIM_INFINITY or most >= wanted:
        return [ok(f"a process may have the {wanted} that central wants")]
    if most < _FEWEST_DESCRIPTORS:
        return [problem(f"a process may have {most}, too few for a hub", advice)]
    return [warning(f"a process may have {most}; central wants {wanted}", advice)]


def clock() -> list[Finding]:
    """Whether time can be measured, and whether the date is a possible one."""
    findings = []
    steps = time.get_clock_info("monotonic").resolution
    if steps > _COARSEST_CLOCK_S:
        text = f"the monotonic clock advances in steps of {steps * 1e3:.3g} ms"
        findings.append(warning(text, "use a kernel with high-resolution timers"))
    installed = Path(__file__).stat().st_mtime
    if time.time() < installed - 86_400.0:
        text = f"the date is {time.strftime('%Y-%m-%d')}, before this hub was installed"
        findings.append(warning(text, "set the clock: timedatectl set-ntp true"))
    return findings or [ok(f"steps of {steps * 1e9:.3g} ns; the date is after its installation")]


def space(robot: RobotDescription) -> list[Finding]:
    """Whether there is room for logs and maps."""
    free: dict[int, tuple[int, Path]] = {}
    for wanted, _ in written_folders(robot).values():
        folder = existing(wanted)
        free.setdefault(folder.stat().st_dev, (shutil.disk_usage(folder).free, folder))
    return [judged_space(room, folder) for room, folder in free.values()]


def judged_space(free: int, folder: Path) -> Finding:
    """The finding about the free space of a disk [bytes]."""
    text = f"{_amount(free)} free at {folder}"
    if free >= _GOOD_SPACE:
        return ok(text)
    advice = f"delete what is not needed; {_amount(_GOOD_SPACE)} are enough for long"
    return problem(text, advice) if free < _LEAST_SPACE else warning(text, advice)


def memory() -> list[Finding]:
    """Whether there is memory for a hub and its modules."""
    return [judged_memory(Path("/proc/meminfo").read_text())]


def judged_memory(table: str) -> Finding:
    """The finding about /proc/meminfo."""
    found = _AVAILABLE.search(table)
    if found is None:
        return warning("the system does not say how much memory there is", "see `free`")
    available = int(found[1]) << 10
    text = f"{_amount(available)} available"
    if available >= _GOOD_MEMORY:
        return ok(text)
    advice = "end other programs; see `ps --sort=-rss -eo rss,pid,args`"
    return problem(text, advice) if available < _LEAST_MEMORY else warning(text, advice)


def processors() -> list[Finding]:
    """Whether the processors have time for the hub."""
    return [judged_load(os.getloadavg()[0], len(os.sched_getaffinity(0)))]


def judged_load(load: float, count: int) -> Finding:
    """The finding about the load of the last minute, given the number of processors."""
    text = f"{count} of {platform.machine()}, load {load:.1f}"
    if load > _BUSY * count:
        return warning(text, "end what is not needed; see `top`")
    return ok(text)


def service(robot_file: str) -> list[Finding]:
    """Whether systemd can run the hub, even after the logout of its user."""
    if not SYSTEMD.is_dir():
        return [ok("systemd does not run this machine; start `rune-hub run` by other means")]
    if (_UNITS / "rune-hub.service").exists():
        return [ok(f"{_UNITS}/rune-hub.service is there; see `systemctl status rune-hub`")]
    own = Path.home() / ".config" / "systemd" / "user" / "rune-hub.service"
    name = user_name()
    if own.exists() and not (_LINGERING / name).exists():
        text = f"{own} runs only while {name} is logged in"
        return [warning(text, f"loginctl enable-linger {name}")]
    if own.exists():
        return [ok(f"{own} is there, and {name} lingers")]
    command = f"rune-hub service {shlex.quote(robot_file)}"
    return [ok(f"systemd is there; `{command}` prints a unit for it")]


def user_name() -> str:
    """Name of the user that runs this, or the number of one without a name."""
    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:  # containers run as users without a name
        return str(os.geteuid())


def _amount(count: int) -> str:
    return f"{count / (1 << 30):.1f} GiB" if count >= 1 << 30 else f"{count >> 20} MiB"
