"""Which key of the US keyboard a character of another keyboard layout is; pure.

Layouts of Rune name keys by their characters on a US keyboard. On another keyboard the same key
types another character. It counts as the US key only if that is certain:

| the language of the system's locale | layouts that must agree |
| --- | --- |
| has layouts below with the script of the character | those |
| has none | all below with this script |

An ASCII letter is never another key: what is printed on the key counts. The rows are those of
xkeyboard-config.
"""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Mapping
from functools import cache
from typing import Final

from hub.values import dataclass

US_KEYS: Final = "`1234567890-=qwertyuiop[]asdfghjkl;'zxcvbnm,./"
"""The keys, row by row."""
_LETTER: Final = US_KEYS.index("a")
"""Position of a key that has a letter in every layout."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyboardLayout:
    """A layout of the keyboard.

    Attributes:
        language: The language that it is for, as locales name it.
        characters: What `US_KEYS` type; a space: no character by themselves.
    """

    language: str
    characters: str

    @property
    def script(self) -> str:
        """The script of its letters."""
        return _script(self.characters[_LETTER])

    def key_of(self, character: str) -> str:
        """The US key that types a character; empty: none."""
        at = self.characters.find(character)
        return US_KEYS[at] if at >= 0 else ""


_ROWS: Final = (
    ("ru", "ё1234567890-=йцукенгшщзхъфывапролджэячсмитьбю."),
    ("uk", "'1234567890-=йцукенгшщзхїфівапролджєячсмитьбю."),
    ("be", "ё1234567890-=йцукенгшўзх'фывапролджэячсмітьбю."),
    ("bg", "(1234567890-.,уеишщксдзц;ьяаожгтнвмчюйъэфхпрлб"),
    ("sr", "`1234567890'+љњертзуиопшђасдфгхјклчћжџцвбнм,.-"),
    ("mk", " 1234567890-=љњертѕуиопшѓасдфгхјклчќзџцвбнм,./"),
    ("el", "`1234567890-=;ςερτυθιοπ[]ασδφγηξκλ 'ζχψωβνμ,./"),
    ("he", ";1234567890-=/'קראטוןםפ][שדגכעיחלךף,זסבהנמצתץ."),
    ("fr", "²&é\"'(-è_çà)=azertyuiop $qsdfghjklmùwxcvbn,;:!"),
    ("de", " 1234567890ß qwertzuiopü+asdfghjklöäyxcvbnm,.-"),
    ("it", "\\1234567890'ìqwertyuiopè+asdfghjklòàzxcvbnm,.-"),
    ("es", "º1234567890'¡qwertyuiop +asdfghjklñ zxcvbnm,.-"),
    ("pt", "\\1234567890'«qwertyuiop+ asdfghjklçºzxcvbnm,.-"),
    ("sv", "§1234567890+ qwertyuiopå asdfghjklöäzxcvbnm,.-"),
    ("nb", "|1234567890+\\qwertyuiopå asdfghjkløæzxcvbnm,.-"),
    ("da", "½1234567890+ qwertyuiopå asdfghjklæøzxcvbnm,.-"),
    ("cs", ";+ěščřžýáíé= qwertzuiopú)asdfghjklů§yxcvbnm,.-"),
    ("hu", "0123456789öüóqwertzuiopőúasdfghjkléáyxcvbnm,.-"),
)
LAYOUTS: Final = tuple(KeyboardLayout(language=name, characters=row) for name, row in _ROWS)


def language_of(environment: Mapping[str, str]) -> str:
    """The language of the locale for characters, such as "ru"; empty: not known."""
    names = (environment.get(name) for name in ("LC_ALL", "LC_CTYPE", "LANG"))
    return next(filter(None, names), "").partition("_")[0].lower()


@cache
def us_key(character: str, language: str | None = None) -> str:
    """The US key of a character, if it is certain; else empty.

    Args:
        character: What was typed, in lower case.
        language: See `language_of`; None: this process's.
    """
    if len(character) != 1 or (character.isascii() and character.isalnum()):
        return ""
    language = language_of(os.environ) if language is None else language
    of_script = [each for each in LAYOUTS if each.script == _script(character)]
    meant = [each for each in of_script if each.language == language] or of_script
    keys = {each.key_of(character) for each in meant}
    return keys.pop() if len(keys) == 1 else ""


def _script(character: str) -> str:
    script = unicodedata.name(character, "").partition(" ")[0]
    return script if script in {"CYRILLIC", "GREEK", "HEBREW"} else "LATIN"
