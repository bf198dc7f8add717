"""The format grammar: what it takes, what it refuses and where, and what counts as equal."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import MessageFormatError
from hub.ipc.formats import codec
from hub.ipc.formats import grammar as formats
from tests.hub.ipc.formats.trees import formats_of
from tests.support.cases import for_each

_GOOD = {
    "int": "int",
    " { int , double } ": "{int,double}",
    "{}": "{}",
    "{\n\tint,\f{string}\r}": "{int,{string}}",
    "[double:16]": "[double:16]",
    "[{int,char}:2,3]": "[{int,char}:2,3]",
    "[[int:2]:03]": "[[int:2]:3]",
    "{int,<ubyte:1>}": "{int,<ubyte:1>}",
    "{int,uint,<{ubyte,<byte:1>}:2,1>}": None,
    "{int,<byte:1>,<double:1>}": "{int,<byte:1>,<double:1>}",
    "{ < {float,<string>} > }": "{<{float,<string>}>}",
    "*{int,*string}": "*{int,*string}",
    "{enum:0}": "{enum:0}",
    "{enum : 2147483647}": "{enum:2147483647}",
    "{enum off , on}": "{enum off,on}",
    "{enum enum}": "{enum enum}",
    "{int,*!}": "{int,*!}",
    "{ *! , *{int, *!} }": "{*!,*{int,*!}}",
    "{byte,{{string,*!},int},*!}": "{byte,{{string,*!},int},*!}",
    "8": "[ubyte:8]",
    "{int,16}": "{int,[ubyte:16]}",
    "[3:int]": "[int:3]",
    "[2:[3 : {char}]]": "[[{char}:3]:2]",
    "[8:3]": "[[ubyte:3]:8]",
    "[[8:3]:2]": "[[[ubyte:3]:8]:2]",
    "{boolean,long,ulong,short,ushort,byte,ubyte,char,float}": None,
}

_BAD = [
    ("", 0, "expected a type, found 'the end'"),
    ("   ", 3, "the end"),
    ("{int,", 5, "expected a type"),
    ("{int,}", 5, "expected a type, found '}'"),
    ("{int double}", 5, "expected ','"),
    ("{,int}", 1, "expected a type"),
    ("{int", 4, "expected ','"),
    ("{int}}", 5, "a complete format must end here"),
    ("int extra", 4, "a complete format must end here"),
    ("[int]", 4, "expected ':'"),
    ("[int:0]", 5, "not between 1"),
    ("[int:-1]", 5, "unexpected character '-'"),
    ("[int:x]", 5, "expected a number"),
    ("[int:99999999999]", 5, "expected a number"),
    ("[int:2,]", 7, "expected a number"),
    ("[{}:3]", 1, "empty structs"),
    ("[[{}:1]:3]", 2, "empty structs"),
    ("{int,<int:5>}", 10, "member 5 is no integer"),
    ("{string,<int:1>}", 13, "member 1 is no integer"),
    ("{float,<int:1>}", 12, "member 1 is no integer"),
    ("{<int:1>,int}", 6, "member 1 is no integer"),
    ("{int,<int:0>}", 10, "not between 1"),
    ("{int,<{}:1>}", 6, "empty structs"),
    ("<int:1>", 0, "directly inside a struct"),
    ("{<>}", 2, "expected a type"),
    ("{<int:>}", 6, "expected a number"),
    ("{<{}>}", 2, "empty structs"),
    ("[<int>:2]", 1, "directly inside a struct"),
    ("{int,[<int:1>:2]}", 6, "directly inside a struct"),
    ("{int,*<int:1>}", 6, "directly inside a struct"),
    ("{int,unknown}", 5, "found 'unknown'"),
    ("{int,doubel}", 5, "did you mean 'double'?"),
    ("{int,bool}", 5, "expected a type"),
    ("{Int}", 1, "did you mean 'int'?"),
    ("{enum}", 5, "expected a name"),
    ("{enum:}", 6, "expected a number"),
    ("{enum:2147483648}", 6, "not between 0"),
    ("{enum a,a}", 8, "twice"),
    ("{enum a,1}", 8, "expected a name"),
    ("{enum a b}", 8, "expected '}'"),
    ("{int,!*}", 5, "unexpected character '!'"),
    ("*!", 0, "a self pointer stands directly inside a struct"),
    ("{int,**!}", 6, "a self pointer stands directly inside a struct"),
    ("{int,[*!:2]}", 6, "a self pointer stands directly inside a struct"),
    ("{int,<*!:1>}", 6, "a self pointer stands directly inside a struct"),
    ("{*!,int,*!}", 8, "two self pointers"),
    ("{int,{*!}}", 5, "a list of empty structs"),
    ("{*!,{}}", 0, "a list of empty structs"),
    ("{*!,<int:1>}", 9, "member 1 is no integer"),
    ("{int;int}", 4, "unexpected character ';'"),
    ("int\0", 3, "unexpected character"),
    ("ünt", 0, "unexpected character"),
    ("[int:١]", 5, "unexpected character"),
    ("0", 0, "not between 1"),
    ("16777217", 0, "not between 1"),
    ("8 int", 2, "a complete format must end here"),
    ("[8]", 2, "expected ':'"),
    ("[8:int:3]", 6, "expected ']'"),
    ("[8:{}]", 3, "empty structs"),
    ("[0:int]", 1, "not between 1"),
    ("{" + "1000000," * 400 + "int}", 3205, "spelt out, it is longer than 4096 characters"),
]


@for_each("text", _GOOD)
def test_good_format_has_one_canonical_spelling(text: str) -> None:
    assert str(formats.parse(text)) == (_GOOD[text] or text)


@for_each(("text", "position", "reason"), _BAD)
def test_malformed_format_is_refused_with_position_and_reason(
    text: str, position: int, reason: str
) -> None:
    with pytest.raises(MessageFormatError) as caught:
        formats.parse(text)
    assert caught.value.position == position
    assert reason in str(caught.value)


@for_each(
    ("within", "beyond"),
    [
        ("*" * 15 + "int", "*" * 16 + "int"),
        ("{" * 16 + "}" * 16, "{" * 17 + "}" * 17),
        ("{" + "int" + " " * 4090 + "}", "{" + "int" + " " * 4092 + "}"),
        ("[byte:16777216]", "[byte:16777217]"),
        ("[[byte:4096]:4096]", "[[byte:4096]:4097]"),
        ("[{int,int}:8388608]", "[{int,int}:8388609]"),
        ("16777216", "16777217"),
        ("[4096:4096]", "[4097:4096]"),
        ("[byte:1,1,1,1,1,1,1,1]", "[byte:1,1,1,1,1,1,1,1,1]"),
        ("{int,<int:1,1,1,1,1,1,1,1>}", "{int,<int:1,1,1,1,1,1,1,1,1>}"),
    ],
)
def test_limits_hold_exactly(within: str, beyond: str) -> None:
    codec.compiled(within)
    with pytest.raises(MessageFormatError):
        formats.parse(beyond)


def test_format_as_wide_as_the_limit_allows_compiles() -> None:
    codec.compiled("{int" + ",<int:1>" * 511 + "}")
    codec.compiled("{string" + ",int" * 1000 + "}")


@for_each(
    ("around", "inside"),
    [("[@:1]", "string"), ("{@,*!}", "byte"), ("*@", "string"), ("{byte,<@:1>}", "{string}")],
)
def test_format_as_deep_as_the_limit_allows_compiles(around: str, inside: str) -> None:
    text = inside
    for _ in range(formats.MAX_DEPTH - 1 - inside.count("{")):
        text = around.replace("@", text)
    codec.compiled(text)
    with pytest.raises(MessageFormatError, match="nested deeper"):
        codec.compiled(around.replace("@", text))


@given(st.text(max_size=60) | st.text("{}[]<>,:*!! 123intenumdoublestring", max_size=60))
def test_any_text_parses_or_is_refused_within_itself(text: str) -> None:
    tree, position = None, 0
    try:
        tree = formats.parse(text)
    except MessageFormatError as error:
        position = error.position
    assert 0 <= position <= len(text)
    assert tree is None or formats.parse(str(tree)) == tree


@given(formats_of())
def test_canonical_text_makes_the_same_tree_again(tree: formats.Format) -> None:
    assert formats.parse(str(tree)) == tree


@given(formats_of(), formats_of())
def test_fingerprints_are_equal_exactly_when_the_trees_are(
    one: formats.Format, other: formats.Format
) -> None:
    spaced = str(one).replace(",", " , ").replace("{e", "{ e")
    assert codec.compiled(str(one)).fingerprint == codec.compiled(spaced).fingerprint
    same = codec.compiled(str(one)).fingerprint == codec.compiled(str(other)).fingerprint
    assert same == (one == other)


@for_each(
    ("text", "fixed"),
    [
        ("{int,[double:3],{enum a,b},[{char}:2]}", True),
        ("{}", True),
        ("{int,string}", False),
        ("{int,<byte:1>}", False),
        ("[{*int}:2]", False),
        ("{int,*!}", False),
    ],
)
def test_fixed_length_means_no_string_pointer_list_or_variable_array(
    text: str, *, fixed: bool
) -> None:
    assert formats.is_fixed_length(formats.parse(text)) is fixed


@for_each(
    ("one", "other", "equal"),
    [
        ("{int, [double:3]}", "{int,[3:double]}", True),
        ("{4}", "{[ubyte:4]}", True),
        ("{{enum a,b}}", "{{enum a , b}}", True),
        ("{{enum a,b}}", "{{enum b,a}}", False),
        ("{{enum a,b}}", "{{enum:1}}", False),
        ("{{enum:1}}", "{{enum:2}}", False),
        ("{{double},int}", "{double,int}", False),
        ("{char}", "{ubyte}", False),
        ("{int,*!}", "*{int,*!}", False),
    ],
)
def test_formats_are_equal_when_they_are_built_alike(one: str, other: str, *, equal: bool) -> None:
    assert (formats.parse(one) == formats.parse(other)) is equal


@given(formats_of(), formats_of())
def test_trees_and_texts_agree_on_what_is_equal(one: formats.Format, other: formats.Format) -> None:
    assert formats.parse(str(one)) == one
    assert (str(one) == str(other)) == (one == other)


def test_a_name_is_no_type() -> None:
    with pytest.raises(MessageFormatError, match="expected a type, found 'pose'"):
        formats.parse("{int,pose}")
