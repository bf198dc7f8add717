"""Values to payload bytes and back, for one format: OMG CDR, little-endian, as ROS 2 writes it.

For each format a pair of functions is generated once, as Python source: neighbouring numbers
become one `struct` call, numeric arrays are views. A payload is the 4-byte encapsulation header
00 01 00 00 and the members. Each primitive is aligned to its own size, counted from behind that
header. Payloads in big-endian order (00 00 00 00) are read too; their arrays are copies.

| format | value | on the wire |
| --- | --- | --- |
| number, boolean | int, float, bool | itself; `long` 8 bytes, `boolean` 1 |
| string | str without NUL | uint32 length with NUL, UTF-8, NUL |
| enum | int, 0 to largest | int32 |
| struct | sequence; decoded as tuple | its members |
| fixed array of numbers | numpy array of its dimensions | the elements |
| sequence of numbers | flat numpy array, or bytes | uint32 count, the elements |
| array of anything else | sequence, flat; decoded as list | as above |
| pointer | None or a value | uint32 0, or uint32 1 and the value |
| struct with a self pointer | struct; the next node or None | uint32 count, the nodes without it |
| pointer to such a struct | None or the first node | the same; count 0 for None |
"""

from __future__ import annotations

import functools
import hashlib
import struct
from collections.abc import Callable
from typing import Any

from hub.errors import CodecError
from hub.ipc.formats import codegen, decoder_source, encoder_source
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import Buffer

_FAULTS = (
    struct.error,
    TypeError,
    ValueError,
    IndexError,
    KeyError,
    ArithmeticError,
    RecursionError,
    AttributeError,
    MemoryError,
)


class Codec:
    """Encodes and decodes the payloads of one format; use `compiled` to get one.

    Attributes:
        tree: The format.
        text: The format in its canonical spelling.
        fingerprint: 64-bit identity of the format: equal formats have equal fingerprints.
        fixed_length: Whether every payload has the same length.
        flat_letters: Letters of one little-endian `struct` for the whole body of a flat format,
        with "x" for padding. Flat: only numbers and structs of numbers. None: it is not flat.
    """

    def __init__(self, tree: formats.Format) -> None:
        self.text = str(tree)
        self.fixed_length = formats.is_fixed_length(tree)
        self.flat_letters = codegen.flat_letters(tree)
        digest = hashlib.blake2b(self.text.encode(), digest_size=8).digest()
        self.fingerprint = int.from_bytes(digest, "little")
        self.tree = tree

    # Generated at first use: no program uses all its formats.

    @functools.cached_property
    def _encode(self) -> Callable[[Any], list[Buffer]]:
        return encoder_source.writer(self.tree)

    @functools.cached_property
    def _decode(self) -> Callable[[Buffer], Any]:
        return decoder_source.reader(self.tree)

    def encode(self, value: Any) -> list[Buffer]:
        """The payload of `value` in pieces; joined, they are the payload.

        Raises:
            CodecError: The value does not fit the format.
        """
        try:
            return self._encode(value)
        except _FAULTS as error:
            text = f"the values do not fit format {self.text[:80]!r}: {error}"
            raise CodecError(text) from error

    def decode(self, payload: Buffer) -> Any:
        """The value in `payload`; numeric arrays are views of it.

        Raises:
            CodecError: The bytes are no payload of this format.
        """
        try:
            return self._decode(payload)
        except _FAULTS as error:
            text = f"{len(payload)} bytes are no payload of {self.text[:80]!r}: {error}"
            raise CodecError(text) from error


@functools.lru_cache(maxsize=1024)
def compiled(text: str) -> Codec:
    """The codec of a format string.

    Raises:
        MessageFormatError: The text is no format.
    """
    return Codec(formats.parse(text))
