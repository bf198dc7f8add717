"""Why no vehicle is found at an address, and what to try, in words; pure."""

from __future__ import annotations

from hub.robots.mavlink.link.address import VehicleAddress, VehicleLinkKind
from hub.robots.mavlink.link.byte_link import ByteLinkState


def unanswered(*, signed: bool, signs: bool) -> str:
    """A sentence for a vehicle that sends and does not answer.

    Args:
        signed: Whether its frames have signatures.
        signs: Whether a key was given.
    """
    if signed and not signs:
        return (
            "it signs its frames and ignores those without its key: give the key's file by --key, "
            "or as [mavlink] key_file; by cable, `rune-hub vehicle key FILE --setup ADDRESS` gives "
            "it a new one"
        )
    return "it sends and does not answer: it may not receive, or needs another signing key"


def silence(address: VehicleAddress, link: ByteLinkState, frames: int, refused: int) -> str:
    """A sentence for a link where no vehicle was found.

    Args:
        address: Where it leads.
        link: Its state.
        frames: Frames that came, none of them of a vehicle's autopilot.
        refused: Frames without a genuine signature, where a key is set.
    """
    place = _place(address)
    if frames:
        return (
            f"{frames} MAVLink frames came {place}, and none is a heartbeat of an autopilot; "
            "see that the vehicle itself is on this link"
        )
    if refused:
        return (
            f"{refused} frames came {place} without a signature of this key; give the vehicle's "
            "key, or none if it does not sign"
        )
    if link.received:
        advice = "see that it sends MAVLink there"
        if address.kind is VehicleLinkKind.SERIAL:
            advice = f"give its rate, such as serial://{address.host}?baud=57600"
        return f"{link.received} bytes came {place}, and none of them is MAVLink; {advice}"
    if link.why and address.kind is VehicleLinkKind.SERIAL:
        return f"no vehicle is {place}: {link.why}"
    return f"no vehicle is {place}{f': {link.why}' if link.why else ''}; {_advice(address)}"


def _place(address: VehicleAddress) -> str:
    """Where it was listened."""
    match address.kind:
        case VehicleLinkKind.SERIAL:
            return f"at {address.host} with {address.baud} baud"
        case VehicleLinkKind.TCP:
            return f"at TCP port {address.port} of {address.host}"
        case VehicleLinkKind.UDP:
            return f"at UDP port {address.port} of {address.host}"
        case _:
            local = "loopback" if _is_loopback(address) else "this machine"
            return f"at UDP port {address.port} of {local}"


def _advice(address: VehicleAddress) -> str:
    match address.kind:
        case VehicleLinkKind.SERIAL:
            return "see that it has power, and that its port and its rate in baud are these"
        case VehicleLinkKind.TCP:
            return "see that it runs there, and that no other program has the connection"
        case VehicleLinkKind.UDP:
            return (
                "see that it waits for datagrams there; where it sends them itself, give "
                f"udp://0.0.0.0:{address.port}"
            )
        case _ if _is_loopback(address):
            return (
                "loopback is within this machine only: give "
                f"udp://0.0.0.0:{address.port} for a vehicle on the network"
            )
        case _:
            return (
                "see that it sends to the address of this machine, and that no firewall is between"
            )


def _is_loopback(address: VehicleAddress) -> bool:
    return address.host.startswith("127.")
