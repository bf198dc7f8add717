"""What the daemon decides, in random histories of modules that crash, hang and do not listen."""

from __future__ import annotations

import random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from hub.gcm.supervision import CapabilityPhase, ModuleOrder, ModulePhase
from hub.robomon.module_lifecycle import ProcessAction
from hub.robomon.module_table import ModuleSpec
from tests.hub.robomon.world import World, ways
from tests.support.repetitions import repetitions

_MODULES = ("a", "b", "c", "d")
_CAPABILITIES = ("A", "B", "C")


@settings(max_examples=repetitions(8, 400))
@given(st.integers(0, 2**32))
def test_random_histories(seed: int) -> None:
    """Whatever modules do and whoever wants what: no storm, no doubles, no zombie, no deadlock."""
    chance = random.Random(seed)
    specs = [
        ModuleSpec(
            name=name,
            command=("x",),
            capabilities=tuple(chance.sample(_CAPABILITIES, chance.randint(0, 2))),
            always=chance.random() < 0.4,
            keep_alive_s=chance.choice([0.0, 2.0, 5.0]),
            start_timeout_s=3.0,
            linger_s=chance.choice([0.0, 1.0, 3.0]),
            restart_limit=chance.randint(0, 4),
            restart_window_s=chance.choice([5.0, 1000.0]),
        )
        for name in _MODULES
    ]
    needs = {name: chance.choice(["", "", *_CAPABILITIES]) for name in _MODULES}
    world = World(*specs, needs=needs)
    for each in specs:
        if chance.random() < 0.7:
            lacks = frozenset(needs[each.name].split())
            world[each.name].learned(frozenset(each.capabilities), lacks)

    def behave(name: str) -> dict[str, Any]:
        del name
        far = float("inf")
        return {
            "announce_at": chance.choice([0.1, 0.3, 1.0, far]),
            "crash_at": chance.choice([far, far, far, 0.0, 0.5, 4.0]),
            "hang_at": chance.choice([far, far, 2.0]),
            "deaf_to": frozenset(
                action
                for action in (ProcessAction.COMMAND, ProcessAction.TERMINATE)
                if chance.random() < 0.2
            ),
        }

    world.behave = behave
    for _ in range(chance.randint(5, 25)):
        kind = chance.random()
        if kind < 0.25:
            order = chance.choice(list(ModuleOrder))
            name = chance.choice(_MODULES)
            world.order(name, order)
            if order is ModuleOrder.STOP:
                held = len(world.starts(name))
                world.run(3.0, wants="A B C")
                assert len(world.starts(name)) == held
                assert name not in world.processes, "lives on after a stop"
        wants = " ".join(chance.sample(_CAPABILITIES, chance.randint(0, 3)))
        world.run(chance.choice([0.2, 1.0, 4.0]), wants=wants)
    # From now on all behave: whatever is wanted and not given up comes to run, the rest ends.
    world.behave = ways()
    for process in world.processes.values():
        process.deaf_to = frozenset()
    world.run(40.0, wants="A")
    view = world.policy.capabilities(world.now).get("A")
    able = [name for name, life in world.policy.lifecycles.items() if "A" in life.provides]
    reachable = any(world[name].usable and not _lacks_for_ever(world, name, set()) for name in able)
    assert view is not None
    assert (view.phase is CapabilityPhase.RUNNING) or not reachable
    world.run(40.0)
    for name, life in world.policy.lifecycles.items():
        needed = any(
            other.phase is ModulePhase.RUNNING and life.provides & other.needs
            for other in world.policy.lifecycles.values()
        )
        replaces = any(f"{name} does its work" in o.why for o in world.policy.lifecycles.values())
        if life.up and not needed and not replaces:
            assert life.spec.always or life.pinned, f"{name} runs and nobody wants it"


def _lacks_for_ever(world: World, name: str, seen: set[str]) -> bool:
    """Whether a module needs what no usable module has."""
    if name in seen:
        return False
    seen.add(name)
    return any(
        not any(
            need in life.provides and life.usable and not _lacks_for_ever(world, other, seen)
            for other, life in world.policy.lifecycles.items()
        )
        for need in world[name].needs
    )
