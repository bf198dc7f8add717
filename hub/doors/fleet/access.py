"""Who may do what at a fleet's router, as Zenoh's table of access control; pure.

All is denied that no rule allows. The subject of a rule is the common name of a certificate.

| certificate | declares, puts and answers | gets |
| --- | --- | --- |
| `robot:NAME` | states, pictures, answers of NAME | commands and queries to NAME, its operators |
| `observe:NAME` | its sessions; `GCM_Stop` and queries as itself | states, pictures, answers |
| `operate:NAME`, `supervise:NAME` | the same, and all commands as itself | the same |
| `router` | all of the fleet; that router has checked its own sessions | all of the fleet |

What a role may command in detail is decided by the robot's gateway, which says it in words.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hub.errors import FleetKeyError
from hub.gcm.navigation import STOP
from hub.ipc.roles import Principal, Role
from hub.zenoh.fleet_keys import ANY, ROBOT, ROUTER, VERSION, KeyKind, parse_operator, pattern

_ALL = [
    *("put", "delete", "query", "reply", "declare_subscriber", "declare_queryable"),
    *("liveliness_token", "liveliness_query", "declare_liveliness_subscriber"),
]
_SHOWN = (
    KeyKind.STATE,
    KeyKind.PICTURE,
    KeyKind.THIN,
    KeyKind.OPERATORS,
    KeyKind.DEFINITIONS,
)
_READ = (KeyKind.LAST, KeyKind.CLOCK, KeyKind.OPERATORS, KeyKind.DEFINITIONS)


def access_table(fleet: str, names: Sequence[str]) -> dict[str, Any]:
    """The table for certificates with these common names.

    Raises:
        FleetKeyError: A name is neither a robot's nor an operator's.
    """
    rules, policies, subjects = [], [], []
    for name in (*names, ROUTER):
        role, _, rest = name.partition(":")
        if name == ROUTER:
            own = [_rule(flow, _ALL, [f"{fleet}/{VERSION}/**"]) for flow in ("ingress", "egress")]
        elif role == ROBOT:
            own = _robot(fleet, rest)
        else:
            own = _operator(fleet, parse_operator(name))
        made = [
            {"id": f"{name} {number}", "permission": "allow", **rule}
            for number, rule in enumerate(own)
        ]
        rules += made
        subjects.append({"id": name, "cert_common_names": [name]})
        policies.append({"rules": [rule["id"] for rule in made], "subjects": [name]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _robot(fleet: str, name: str) -> list[dict[str, Any]]:
    """The rules of a robot.

    Raises:
        FleetKeyError: It has no name.
    """
    if not name or name == ANY:
        raise FleetKeyError(name, "a robot's certificate has the robot's name")
    shown = [pattern(fleet, kind, robot=name) for kind in (*_SHOWN, KeyKind.REFUSAL)]
    answered = [pattern(fleet, kind, robot=name) for kind in (*_READ, KeyKind.ASK)]
    alive, command, operator = (
        pattern(fleet, kind, robot=name)
        for kind in (KeyKind.ALIVE, KeyKind.COMMAND, KeyKind.OPERATOR)
    )
    return [
        _rule("ingress", ["put"], shown),
        _rule("ingress", ["declare_queryable", "reply"], answered),
        _rule("ingress", ["liveliness_token"], [alive]),
        _rule("ingress", ["declare_subscriber"], [command]),
        _rule("ingress", ["declare_liveliness_subscriber", "liveliness_query"], [operator, alive]),
        _rule("egress", ["put"], [command]),
        _rule("egress", ["query"], _asked(fleet, answered)),
        _rule("egress", ["declare_subscriber"], _asked(fleet, shown)),
        _rule("egress", ["liveliness_token"], [operator, alive]),
    ]


def _operator(fleet: str, operator: Principal) -> list[dict[str, Any]]:
    """The rules of an operator."""
    own = pattern(fleet, KeyKind.REFUSAL, operator=operator)
    shown = [*(pattern(fleet, kind) for kind in _SHOWN), own]
    asked = [
        *(pattern(fleet, kind) for kind in _READ),
        pattern(fleet, KeyKind.ASK, operator=operator),
    ]
    alive, session = (
        pattern(fleet, KeyKind.ALIVE),
        pattern(fleet, KeyKind.OPERATOR, operator=operator),
    )
    message = STOP.name if operator.role is Role.OBSERVE else ANY
    command = pattern(fleet, KeyKind.COMMAND, operator=operator, message=message)
    return [
        _rule("ingress", ["put"], [command]),
        _rule("ingress", ["query"], asked),
        _rule("ingress", ["liveliness_token"], [session]),
        _rule("ingress", ["declare_subscriber"], shown),
        _rule("ingress", ["declare_liveliness_subscriber", "liveliness_query"], [alive]),
        _rule("egress", ["put"], shown),
        _rule("egress", ["reply", "declare_queryable"], asked),
        _rule("egress", ["declare_subscriber"], [command]),
        _rule("egress", ["liveliness_token"], [alive]),
    ]


def _asked(fleet: str, keys: list[str]) -> list[str]:
    """These keys, and the same of all robots: who asks all at once writes so."""
    start = f"{fleet}/{VERSION}/"
    every = [f"{start}{ANY}/{key.removeprefix(start).partition('/')[2]}" for key in keys]
    return [*keys, *every]


def _rule(flow: str, messages: list[str], keys: list[str]) -> dict[str, Any]:
    return {"flows": [flow], "messages": messages, "key_exprs": keys}
