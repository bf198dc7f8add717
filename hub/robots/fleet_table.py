"""How a robot joins a fleet: the table [fleet] of a robot file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import EndpointError, FleetKeyError
from hub.toml_reader import key, number, plain_name, text
from hub.values import dataclass
from hub.zenoh.fleet_keys import DEFAULT_FLEET, check_fleet
from hub.zenoh.settings import (
    DEFAULT_PLACE,
    CertificateFiles,
    RouterPlace,
    client_settings,
    parse_place,
)


def _place(value: object) -> RouterPlace:
    try:
        return parse_place(text(300)(value))
    except EndpointError as error:
        raise toml.RefusedError(str(error)) from error


def _fleet(value: object) -> str:
    try:
        return check_fleet(text(300)(value))
    except FleetKeyError as error:
        raise toml.RefusedError(str(error)) from error


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetTable:
    """How a robot joins a fleet."""

    place: RouterPlace = key(
        _place,
        parse_place(DEFAULT_PLACE),
        "where the fleet's router listens: `tcp/HOST:PORT`, or `tls/HOST:PORT` with certificates",
        at="router",
        without=f"`{DEFAULT_PLACE}`",
    )
    fleet: str = key(_fleet, DEFAULT_FLEET, "name of the fleet", at="fleet")
    name: str = key(plain_name(64), "", "the robot's name in the fleet", without="the robot's name")
    certificates: str = key(
        text(1000), "", "folder with the robot's certificate", without="none: only `tcp/`"
    )
    thin_hz: float = key(
        number(0.1, 50.0), 2.0, "rate of the states for those with a thin line [Hz]"
    )

    def client_settings(self, name: str) -> dict[str, Any]:
        """The settings of the session of a robot of this name.

        Raises:
            EndpointError: TLS and certificates do not go together.
        """
        files = None
        if self.certificates:
            files = CertificateFiles.of(Path(self.certificates), f"robot-{name}")
        return client_settings(self.place, certificates=files)
