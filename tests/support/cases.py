"""Many small cases in one test: a test for each costs more than what it does."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

Test = Callable[..., None]


def for_each(names: str | tuple[str, ...], values: Iterable[Any]) -> Callable[[Test], Test]:
    """As `pytest.mark.parametrize`, for pure functions; all cases that fail are told together.

    Args:
        names: The parameter, or the parameters of which each value is a tuple.
        values: The cases.
    """
    several = not isinstance(names, str)
    cases = list(values)

    def looping(test: Test) -> Test:
        @functools.wraps(test)
        def run(**others: Any) -> None:
            failed: list[Exception] = []
            for case in cases:
                given = dict(zip(names, case, strict=True)) if several else {names: case}
                try:
                    test(**given, **others)
                except Exception as error:  # noqa: BLE001 - the others are tried first
                    error.add_note(f"of {given}"[:1000])
                    failed.append(error)
            if failed:
                text = f"{len(failed)} of {len(cases)} cases"
                raise ExceptionGroup(text, failed)

        signature = inspect.signature(test)
        kept = [each for name, each in signature.parameters.items() if name not in given_names]
        run.__signature__ = signature.replace(parameters=kept)  # type: ignore[attr-defined]
        return run

    given_names = set(names) if several else {names}
    return looping
