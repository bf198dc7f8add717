"""The certificates of a fleet: an authority, and one certificate for each robot and operator.

The folder is the authority's. `openssl` makes keys and certificates. The list in it says which
certificates count: a router reads it again when it changes.

| file | holds |
| --- | --- |
| `authority.key`, `authority.pem` | the authority; its key never leaves the folder |
| `router.key`, `router.pem` | the router, made with the role `router` |
| `router-HOST.key`, `router-HOST.pem` | another router, at that host |
| `ROLE-NAME.key`, `ROLE-NAME.pem` | what to copy, with `authority.pem`, to that machine |
| `list.toml` | the certificates that count, by common name |
"""

from __future__ import annotations

import ipaddress
import re
import secrets
import shutil
import subprocess
import tempfile
from pathlib import Path

from hub.errors import FleetKeyError, KeyFileError, KeyNameError
from hub.ipc.security import key_files
from hub.zenoh.certificate_facts import CertificateFacts
from hub.zenoh.fleet_keys import HOLDERS, ROUTER
from hub.zenoh.settings import CertificateFiles

_LONGEST_NAME = 50
"""A common name has 64 characters at most, with the role."""
_AUTHORITY_DAYS = 3650
_ADVICE = "put the file back, or make new certificates in another folder"
_CURVE = ("ec", "-pkeyopt", "ec_paramgen_curve:P-256")


class Certificates:
    """The certificates in one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._list = folder / "list.toml"

    def holders(self) -> tuple[str, ...]:
        """The common names that count, such as "operate:alice".

        Raises:
            KeyFileError: The list is damaged or open to others.
        """
        if not key_files.is_there(self._list):
            return ()
        names = key_files.read_private(self._list, advice=_ADVICE).get("names")
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise KeyFileError(self._list, f"it has no list of names; {_ADVICE}")
        return tuple(names)

    def changed(self) -> int:
        """A number that is another one after a change of the list."""
        try:
            return self._list.stat().st_mtime_ns
        except OSError:
            return 0

    def of_router(self) -> CertificateFiles:
        """The files of the router.

        Raises:
            KeyFileError: They are not there.
        """
        files = self._of(ROUTER)
        if not key_files.is_there(files.key):
            reason = "it is not there; make it: rune-hub fleet keys make HOST --role router"
            raise KeyFileError(files.key, reason)
        return files

    def routers(self) -> tuple[str, ...]:
        """The names of the certificates of routers: "router", or "router-HOST" for another host."""
        return tuple(sorted(path.stem for path in self.folder.glob(f"{ROUTER}*.pem")))

    def facts(self, name: str) -> CertificateFacts:
        """What a certificate says, also one that has ended, or whose key is elsewhere.

        Args:
            name: One of `holders` or of `routers`.

        Raises:
            KeyFileError: It is not there or damaged, or there is no `openssl`.
        """
        path = self._of(name.replace(":", "-", 1)).certificate
        if not key_files.is_there(path):
            raise KeyFileError(path, f"it is not there; {_ADVICE}")
        said = self._openssl("x509", "-in", str(path), "-noout", "-dates", path=path)
        times = dict(line.split("=", 1) for line in said.splitlines())
        return CertificateFacts.dated(name, times["notBefore"], times["notAfter"])

    def make(self, name: str, role: str, *, days: int) -> CertificateFiles:
        """Make a certificate and put it on the list; the authority is made first if there is none.

        Args:
            name: Of the robot or operator; of a router, its host.
            role: One of `HOLDERS`.
            days: How long it counts.

        Raises:
            KeyNameError: The name is taken or invalid.
            KeyFileError: A file cannot be used, or there is no `openssl`.
        """
        common = ROUTER if role == ROUTER else f"{role}:{name}"
        if not key_files.is_key_name(name.replace(".", "-")) or len(name) > _LONGEST_NAME:
            text = f"{name[:80]!r} is no name of 1 to {_LONGEST_NAME} letters, digits, ., - and _"
            raise KeyNameError(text)
        if common in self.holders():
            text = f"{common} has a certificate; first say: rune-hub fleet keys remove {common}"
            raise KeyNameError(text)
        key_files.private_folder(self.folder)
        self._need_authority()
        alone = role == ROUTER and not self._is_of_another_router(name)
        files = self._of(ROUTER if alone else f"{role}-{name}")
        hosts = [name, "localhost", "127.0.0.1"] if role == ROUTER else ["localhost"]
        self._sign(files, common, hosts, days)
        if role != ROUTER:
            self._write([*self.holders(), common])
        return files

    def remove(self, common: str) -> None:
        """Let a certificate count no more.

        Raises:
            KeyNameError: There is none.
            KeyFileError: A file cannot be used.
        """
        names = self.holders()
        if common not in names:
            text = f"there is no certificate {common[:80]!r}; `rune-hub fleet keys list` shows all"
            raise KeyNameError(text)
        self._write([name for name in names if name != common])

    def _of(self, name: str) -> CertificateFiles:
        return CertificateFiles.of(self.folder, name)

    def _is_of_another_router(self, host: str) -> bool:
        """Whether the folder's own router is there, at another host."""
        own = self._of(ROUTER).certificate
        if not key_files.is_there(own):
            return False
        named = self._openssl("x509", "-in", str(own), "-noout", "-ext", "subjectAltName")
        return host not in re.split(r"[\s,]*(?:DNS|IP Address):|\s", named)

    def _write(self, names: list[str]) -> None:
        lines = "".join(f'    "{name}",\n' for name in sorted(names))
        key_files.write_private(self._list, f"names = [\n{lines}]\n")

    def _need_authority(self) -> None:
        key, certificate = self.folder / "authority.key", self.folder / "authority.pem"
        if key_files.is_there(key):
            return
        self._openssl(
            "req", "-x509", "-newkey", *_CURVE, "-nodes", "-keyout", str(key),
            "-out", str(certificate), "-days", str(_AUTHORITY_DAYS), "-subj", "/CN=rune-fleet",
        )  # fmt: skip
        key.chmod(0o600)

    def _sign(self, files: CertificateFiles, common: str, hosts: list[str], days: int) -> None:
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            request, extension = Path(folder) / "request", Path(folder) / "extension"
            named = ",".join(f"{'IP' if _is_ip(host) else 'DNS'}:{host}" for host in hosts)
            extension.write_text(
                f"subjectAltName={named}\nextendedKeyUsage=serverAuth,clientAuth\n"
            )
            self._openssl(
                "req", "-newkey", *_CURVE, "-nodes", "-keyout", str(files.key),
                "-out", str(request), "-subj", f"/CN={common}",
            )  # fmt: skip
            files.key.chmod(0o600)
            self._openssl(
                "x509", "-req", "-in", str(request), "-CA", str(files.authority),
                "-CAkey", str(self.folder / "authority.key"), "-out", str(files.certificate),
                "-set_serial", str(secrets.randbits(63)), "-days", str(days),
                "-extfile", str(extension),
            )  # fmt: skip

    def _openssl(self, *words: str, path: Path | None = None) -> str:
        """What it prints; `path` is the file to name in an error, else the folder."""
        program = shutil.which("openssl")
        if program is None:
            raise KeyFileError(self.folder, "openssl makes certificates and is missing; install it")
        done = subprocess.run([program, *words], capture_output=True, text=True, check=False)
        if done.returncode:
            why = done.stderr.strip().splitlines()
            reason = f"openssl refused: {why[-1] if why else done.returncode}"
            raise KeyFileError(path or self.folder, reason)
        return done.stdout


def files_of(folder: Path, common: str) -> CertificateFiles:
    """The files of a certificate in a folder, by its common name.

    Raises:
        FleetKeyError: It is no common name.
    """
    role, colon, name = common.partition(":")
    if role not in HOLDERS or not colon or not name:
        raise FleetKeyError(common, f"write ROLE:NAME, with one of {', '.join(HOLDERS[1:])}")
    return CertificateFiles.of(folder, f"{role}-{name}")


def _is_ip(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
