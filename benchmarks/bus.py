"""The bus beside its peers: throughput, latency, queries, cost, growth.

Publisher, broker and subscribers are processes of their own. Throughput is lossless: a window of
messages under way, kept in shared memory beside the bus, holds every sender back alike. Contenders
take turns, each figure is a median over the rounds, and ratios are of one and the same run.

"rune" and "proxy" run over ipc://, as modules of one machine do; "-tcp" says otherwise, and so do
all peers. "rune" hands messages to neighbours directly, as it usually does. "rune-tcp" sends all
through central.

A message of 48 bytes is typed: every contender encodes a dataclass, decodes it into another one and
hands that to a function; only "proxy" sends raw bytes and reads two numbers.
`--only` and `--peers` choose, `--quick` is for tuning; peers come with `make bench-peers`.
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

from benchmarks.figures import report, say
from benchmarks.peers.contest import Contender, Outcome, Stage, median, stages

SMALL, MIDDLE, LARGE = 48, 1024, 57_600

CONTENDERS = (
    Contender(name="rune", module="rune_bus", transport="ipc"),
    Contender(name="proxy", module="raw_zmq", transport="ipc"),
    Contender(name="zenoh", module="zenoh_bus", needs="zenoh"),
    Contender(name="nats", module="nats_bus", needs="nats"),
    Contender(name="rune-tcp", module="rune_bus", options={"near": False}),
    Contender(name="proxy-tcp", module="raw_zmq"),
    Contender(
        name="rune-picture",
        module="rune_bus",
        transport="ipc",
        options={"plane": "PICTURE"},
    ),
    Contender(
        name="zenoh-no-shm", module="zenoh_bus", needs="zenoh", options={"shared_memory": False}
    ),
    Contender(name="mosquitto", module="mosquitto_bus", needs="paho", program="mosquitto"),
    Contender(name="lcm", module="lcm_bus", needs="lcm", transport=""),
)
QUICK = ("rune", "proxy", "zenoh", "nats")
ALWAYS = ("rune", "rune-tcp", "rune-picture")

_SIX = (*QUICK, "rune-tcp", "proxy-tcp")
_LARGE_ONES = (*_SIX, "rune-picture", "zenoh-no-shm")
_OTHERS = ("mosquitto", "lcm")
FLOWS = {
    (SMALL, 1): (*_SIX, *_OTHERS),
    (SMALL, 4): _SIX,
    (MIDDLE, 1): QUICK,
    (MIDDLE, 4): QUICK,
    (LARGE, 1): (*_LARGE_ONES, *_OTHERS),
    (LARGE, 4): _LARGE_ONES,
}
PACES = {
    (SMALL, 1000.0): (*_SIX, *_OTHERS),
    (LARGE, 30.0): (*_LARGE_ONES, *_OTHERS),
}
ASKERS = _SIX[:5]
_IPC, _TCP = "both over ipc://", "both over TCP"


def _same_work(size: str) -> tuple[tuple[str, str, str, str], ...]:
    return (
        (f"throughput_{size}_vs_proxy", "rune", "proxy", _IPC),
        (f"throughput_{size}_vs_proxy_tcp", "rune-tcp", "proxy-tcp", _TCP),
        (f"throughput_{size}_vs_zenoh", "rune", "zenoh", ""),
        (f"throughput_{size}_vs_nats", "rune", "nats", ""),
    )


RATIOS = {
    SMALL: _same_work("48B"),
    MIDDLE: tuple(each for each in _same_work("1KiB") if each[1] == "rune"),
    LARGE: (
        ("throughput_57600B_vs_proxy", "rune-tcp", "proxy-tcp", _TCP),
        ("throughput_57600B_vs_proxy_ipc", "rune", "proxy", _IPC),
        ("throughput_57600B_vs_zenoh_no_shm", "rune-tcp", "zenoh-no-shm", _TCP),
        ("throughput_57600B_vs_nats", "rune-tcp", "nats", _TCP),
        ("shm_57600B_vs_zenoh_shm", "rune-picture", "zenoh", "shared memory both"),
    ),
}
"""By size: figure, Rune, peer, note; without a note Rune is over ipc:// and the peer over TCP."""
BARS = {
    "bus.throughput_48B_vs_proxy": 0.7,
    "bus.throughput_48B_vs_zenoh": 1.5,
    "bus.throughput_48B_vs_nats": 3.0,
    "bus.throughput_57600B_vs_proxy": 0.9,
    "bus.shm_57600B_vs_zenoh_shm": 1.4,
    "bus.shm_57600B_vs_zenoh_shm_4_subscribers": 1.4,
}
ROUNDS = 3
SECONDS = 0.5

RECORDED = "cmu-ipc (C, recorded)"

Results = dict[str, list[Outcome]]


def measured(
    ready: Mapping[str, Stage], names: Sequence[str], run: Callable[[Stage], Outcome], what: str
) -> Results:
    """Every contender in turn, round after round; without those that are not there."""
    results: Results = defaultdict(list)
    for _ in range(ROUNDS):
        for name in names:
            if name not in ready:
                continue
            try:
                outcome = run(ready[name])
            except TimeoutError as problem:
                say(f"{name}: {problem}")
            else:
                results[name].append(outcome)
    shown = ", ".join(f"{name} {_short(outcomes)}" for name, outcomes in results.items())
    say(f"{what}: {shown}")
    return results


def _short(outcomes: Sequence[Outcome]) -> str:
    lost = sum(outcome.lost for outcome in outcomes)
    spread = "/".join(f"{outcome.per_second:.0f}" for outcome in outcomes)
    times = f" p50 {median(outcomes, 'p50'):.0f} us" if outcomes[0].times[-1] else ""
    return f"{spread} per s{times}" + (f" LOST {lost}" if lost else "")


def ratio(
    name: str,
    results: Results,
    attribute: str,
    ours: str,
    peer: str,
    *,
    bar: float | None,
    better: str,
    note: str = "",
) -> None:
    """Report our median through a peer's; null where either is missing."""
    absent = [each for each in (ours, peer) if each not in results]
    if absent:
        report(name, None, "x", bar=bar, better=better, note=f"without {' and '.join(absent)}")
        return
    value = median(results[ours], attribute) / median(results[peer], attribute)
    lost = sum(outcome.lost for outcome in results[ours])
    said = "; ".join(part for part in (note, f"{ours} lost {lost}" if lost else "") if part)
    report(name, value, "x", bar=bar, better=better, note=said)


def medians(results: Results, attribute: str, leave_out: str = "") -> dict[str, float]:
    """The median of each contender, for the figures' peers."""
    return {
        name: round(median(outcomes, attribute), 2)
        for name, outcomes in results.items()
        if name != leave_out
    }


def plain(
    name: str,
    results: Results,
    attribute: str,
    unit: str,
    *,
    better: str = "lower",
    bar: float | None = None,
    recorded: float | None = None,
    ours: str = "rune",
    note: str = "",
) -> None:
    """Report our own median with those of the peers beside it."""
    peers = medians(results, attribute, ours)
    if recorded is not None:
        peers[RECORDED] = recorded
    if ours not in results:
        report(name, None, unit, bar=bar, better=better, peers=peers, note=f"without {ours}")
        return
    value = median(results[ours], attribute)
    report(name, value, unit, bar=bar, better=better, peers=peers, note=note)


def throughput(ready: Mapping[str, Stage], flows: Mapping[tuple[int, int], Sequence[str]]) -> None:
    """Lossless messages per second, and what each costs."""
    for (size, subscribers), names in flows.items():
        what = f"{_named(size)}{'' if subscribers == 1 else f'_{subscribers}_subscribers'}"
        results = measured(
            ready,
            names,
            lambda stage, s=size, n=subscribers: stage.flow(s, n, SECONDS),
            f"throughput {what}",
        )
        recorded = {(SMALL, 1): 27_000, (LARGE, 1): 348e6 / LARGE}.get((size, subscribers))
        plain(
            f"bus.msgs_{what}_per_s",
            results,
            "per_second",
            "1/s",
            better="higher",
            bar=recorded,
            recorded=recorded,
            note=_costs(results),
        )
        _throughput_ratios(size, subscribers, results)
        if (size, subscribers) == (SMALL, 1):
            note = "total of sender, broker and subscriber at full speed"
            plain("bus.cpu_48B_us", results, "total_us", "us", note=note)
            note = "resident, after 48 B to one subscriber"
            plain("bus.broker_MB", results, "broker_mb", "MB", bar=64, note=note)
            note = "the worst round; 200 messages under way at most"
            worst = max((outcome.lost for outcome in results["rune"]), default=None)
            report("bus.lost_48B", worst, "messages", bar=0, note=note)


def _throughput_ratios(size: int, subscribers: int, results: Results) -> None:
    more = "" if subscribers == 1 else f"_{subscribers}_subscribers"
    for name, ours, peer, about in RATIOS[size]:
        note = about or _over_tcp(results, "per_second", peer)
        full = f"bus.{name}{more}"
        bar = BARS.get(full)
        ratio(full, results, "per_second", ours, peer, bar=bar, better="higher", note=note)


def _named(size: int) -> str:
    return "1KiB" if size == MIDDLE else f"{size}B"


def _over_tcp(results: Results, attribute: str, peer: str) -> str:
    if peer not in results or "rune-tcp" not in results:
        return "ours over ipc://"
    value = median(results["rune-tcp"], attribute) / median(results[peer], attribute)
    return f"ours over ipc://; over TCP {value:.2f}"


def _costs(results: Results) -> str:
    """What a message costs the three kinds of processes."""
    parts = []
    for name, outcomes in results.items():
        each = [median(outcomes, f"{part}_us") for part in ("sender", "broker", "receiver")]
        parts.append(f"{name} {each[0]:.2f}+{each[1]:.2f}+{each[2]:.2f}")
    return "CPU us a message, sender+broker+subscribers: " + ", ".join(parts)


def latency(ready: Mapping[str, Stage], paces: Mapping[tuple[int, float], Sequence[str]]) -> None:
    """From just before a message is made to the handler, at a steady rate."""
    for (size, hertz), names in paces.items():
        seconds = 0.7 if hertz > 100 else 1.2
        results = measured(
            ready,
            names,
            lambda stage, s=size, h=hertz, t=seconds: stage.pace(s, h, t),
            f"latency {_named(size)}",
        )
        note = f"{_named(size)} at {hertz:.0f} Hz"
        recorded = 73.0 if size == SMALL else None
        end = "" if size == SMALL else f"_{_named(size)}"
        plain(f"bus.latency{end}_p50_us", results, "p50", "us", recorded=recorded, note=note)
        plain(f"bus.latency{end}_p99_us", results, "p99", "us", note=note)
        note += "; total of sender, broker and subscriber"
        plain(f"bus.cpu_paced{end}_us", results, "total_us", "us", note=note)
        if size == SMALL:
            for peer, bar in (("proxy", 1.3), ("zenoh", 0.8), ("nats", 0.8)):
                said = _over_tcp(results, "p50", peer) if peer != "proxy" else "both over ipc://"
                ratio(
                    f"bus.latency_p50_vs_{peer}", results, "p50", "rune", peer,
                    bar=bar, better="lower", note=said,
                )  # fmt: skip
            ratio(
                "bus.latency_p50_vs_proxy_tcp", results, "p50", "rune-tcp", "proxy-tcp",
                bar=1.3, better="lower", note="both over TCP",
            )  # fmt: skip
        elif "rune-picture" in results:
            note = f"{_named(size)} at {hertz:.0f} Hz through shared memory"
            ours = "rune-picture"
            plain("bus.latency_picture_p50_us", results, "p50", "us", ours=ours, note=note)


def queries(ready: Mapping[str, Stage], names: Sequence[str]) -> None:
    """Round trips of typed 48-byte queries, one after the other; the proxy relays raw bytes."""
    results = measured(ready, names, lambda stage: stage.queries(SECONDS), "queries")
    plain("bus.query_p50_us", results, "p50", "us", bar=300, recorded=44.0, note=_costs(results))
    plain("bus.query_p99_us", results, "p99", "us")
    note = _over_tcp(results, "p50", "nats")
    ratio("bus.query_vs_nats", results, "p50", "rune", "nats", bar=0.65, better="lower", note=note)
    note = _over_tcp(results, "p50", "zenoh")
    ratio(
        "bus.query_vs_zenoh", results, "p50", "rune", "zenoh", bar=None, better="lower", note=note
    )
    note = "a raw relay of two parts through a ROUTER in Python, both over ipc://"
    ratio(
        "bus.query_vs_relay", results, "p50", "rune", "proxy", bar=None, better="lower", note=note
    )


def growth(stage: Stage) -> None:
    """Whether a message costs the same with many definitions, and among many modules."""
    few, many, defined, alone, among = [], [], [], [], []

    def flow(count: int) -> Outcome:
        return stage.flow(SMALL, 1, SECONDS, definitions=count)

    try:
        for _ in range(ROUNDS):
            many.append(flow(1000))
            few.append(flow(1))
        _flat("bus.growth_1000_definitions", few, many, "all 1,000 published in turn")
    except TimeoutError as problem:
        _not_flat("bus.growth_1000_definitions", problem)
    try:
        for _ in range(ROUNDS):
            defined.append(stage.flow(SMALL, 1, SECONDS, definitions=1000, published=1))
        note = "1,000 defined and subscribed to, one of them published"
        _flat("bus.growth_1000_defined", few, defined, note)
    except TimeoutError as problem:
        _not_flat("bus.growth_1000_defined", problem)
    try:
        for _ in range(ROUNDS):
            alone.append(flow(1))
            with stage.crowd(98, 7):
                among.append(flow(1))
        note = "100 modules connected, 98 of them idle; their own cost is not counted"
        _flat("bus.growth_100_modules", alone, among, note)
    except TimeoutError as problem:
        _not_flat("bus.growth_100_modules", problem)


def _flat(name: str, before: Sequence[Outcome], after: Sequence[Outcome], note: str) -> None:
    one, other = median(before, "total_us"), median(after, "total_us")
    lost = sum(outcome.lost for outcome in after)
    said = f"CPU a message {one:.1f} and {other:.1f} us; {note}" + f"; lost {lost}" * bool(lost)
    report(name, other / one, "x", bar=1.2, note=said)


def _not_flat(name: str, problem: TimeoutError) -> None:
    say(f"{name}: {problem}")
    report(name, None, "x", bar=1.2, note="a run did not come to its end")


def rest() -> None:
    """A new central with 20 connected modules that have nothing to say."""
    with stages(CONTENDERS[:1]) as ready, ready["rune"].crowd(20, 4):
        ready["rune"].rest(1.0)
        readings = [ready["rune"].rest(1.5) for _ in range(ROUNDS)]
    percent = statistics.median(cpu for cpu, _ in readings)
    megabytes = max(memory for _, memory in readings)
    report("bus.rest_20_modules_cpu_percent", percent, "%", bar=1.0, note="of one core")
    report("bus.rest_20_modules_MB", megabytes, "MB", bar=64, note="resident")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parts = ("throughput", "latency", "query", "growth", "rest")
    parser.add_argument("--only", choices=parts, help="one part")
    parser.add_argument("--quick", action="store_true", help="48 B to one subscriber, and queries")
    parser.add_argument("--peers", default="", help="these peers alone: zenoh,nats,...")
    options = parser.parse_args()

    chosen = [name for name in options.peers.split(",") if name]
    wanted = [
        contender
        for contender in CONTENDERS
        if (not chosen or contender.name in (*ALWAYS, *chosen))
        and (not options.quick or contender.name in QUICK)
    ]
    flows = {(SMALL, 1): FLOWS[SMALL, 1]} if options.quick else FLOWS
    paces = {(SMALL, 1000.0): PACES[SMALL, 1000.0]} if options.quick else PACES
    # Ends as an error does: with it end the brokers, and their files are removed.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    say(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with stages(wanted) as ready:
        work: dict[str, Callable[[], None]] = {
            "throughput": lambda: throughput(ready, flows),
            "latency": lambda: latency(ready, paces),
            "query": lambda: queries(ready, ASKERS),
        }
        if not options.quick or options.only:
            work |= {"growth": lambda: growth(ready["rune"]), "rest": rest}
        for part, measure in work.items():
            if options.only in (None, part):
                measure()


if __name__ == "__main__":
    main()
