"""The key of a blind study: which code is which condition, readable by its owner alone."""

from __future__ import annotations

from pathlib import Path

from hub.files import replace
from rune_study.errors import StudyError
from rune_study.plan.steps import codes
from rune_study.plan.study_spec import StudySpec

_HEAD = "# Who reads this is no longer blind. `rune study plan --unblind` shows the same.\n"


def key_path(folder: Path) -> Path:
    """Where the key of a study is."""
    return folder / ".blind" / "key.toml"


def write_key(study: StudySpec) -> None:
    """Write the key of a blind study, unless it is there.

    Raises:
        StudyError: It cannot be written.
    """
    path = key_path(study.folder)
    if not study.design.blind or path.exists():
        return
    lines = [_HEAD]
    for code, levels in sorted(zip(codes(study), study.levels, strict=True)):
        lines.append(f"[{code}]\n")
        lines += [f"{_quoted(name)} = {_value(level)}\n" for name, level in levels.items()]
    try:
        path.parent.mkdir(mode=0o700, exist_ok=True)
        replace(path, "".join(lines).encode(), mode=0o600)
    except OSError as fault:
        text = f"{path} cannot be written: {fault.strerror}"
        raise StudyError(text) from fault


def _value(level: object) -> str:
    if isinstance(level, bool):
        return str(level).lower()
    return str(level) if isinstance(level, int | float) else _quoted(str(level))


def _quoted(text: str) -> str:
    """A TOML string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
