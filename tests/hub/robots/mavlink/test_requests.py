"""Commands and parameters that wait for answers."""

import math
import struct

import pytest

from hub.robots.mavlink.profiles.profile import OLDER_NAMES
from hub.robots.mavlink.vehicle.parameter_reads import ParameterReads, parameter_value
from hub.robots.mavlink.vehicle.requests import RequestKind, RequestQueue, VehicleRequest
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser


class Asked:
    """A request whose results are kept."""

    def __init__(self, queue, kind=RequestKind.QUESTION, command=511, tries=3):
        self.results: list[int] = []
        self.request = VehicleRequest(
            kind=kind,
            command=command,
            parameters=(),
            answered=lambda result, _now: self.results.append(result),
            tries=tries,
        )
        queue.add(self.request)


def test_a_command_is_sent_three_times_and_then_has_no_answer():
    queue = RequestQueue()
    asked = Asked(queue)
    sent = [now / 10 for now in range(40) if queue.due(now / 10)]
    assert sent == pytest.approx([0.0, 0.7, 1.4])
    assert asked.results == [-1]
    assert not queue


def test_an_answer_to_what_was_not_sent_is_not_taken():
    queue = RequestQueue()
    asked = Asked(queue)
    queue.answer(511, 0, 0.0)
    assert asked.results == []
    queue.due(0.1)
    queue.answer(400, 0, 0.2)
    queue.answer(511, 2, 0.2)
    assert asked.results == [2]


@pytest.mark.parametrize(("result", "again"), [(5, 5.0), (1, 0.5)])
def test_it_waits_where_a_vehicle_is_busy(result, again):
    queue = RequestQueue()
    asked = Asked(queue)
    queue.due(0.0)
    queue.answer(511, result, 1.0)
    assert asked.results == []
    assert queue.due(1.0 + again - 0.01) is None
    assert queue.due(1.0 + again + 0.01) is asked.request


def test_disarming_comes_first_then_orders_then_questions():
    queue = RequestQueue()
    question = Asked(queue)
    assert queue.due(0.0) is question.request
    order = Asked(queue, RequestKind.ORDER, 176)
    disarm = Asked(queue, RequestKind.DISARM, 400)
    for each in (disarm, order):
        assert queue.due(0.1) is each.request
        queue.answer(each.request.command, 0, 0.1)
    queue.answer(511, 0, 0.2)
    assert question.results == [0]


def test_questions_are_bounded_and_orders_are_never_left_out():
    queue = RequestQueue()
    for _ in range(1000):
        Asked(queue)
    assert len(queue) == 64
    disarm = Asked(queue, RequestKind.DISARM, 400)
    assert queue.due(0.0) is disarm.request


def read(reads, seconds, answers=()):
    """The names that are asked for; those in `answers` come."""
    names = []
    for step in range(round(seconds / 0.05)):
        if name := reads.due(step * 0.051):
            names.append(name)
            if name in answers:
                reads.take(name, 1.0)
    return names


def test_a_name_that_does_not_come_is_asked_for_four_times_and_then_seldom():
    reads = ParameterReads()
    reads.begin(["FS_ACTION", "NEW_NAME"])
    names = read(reads, 1.0, answers={"FS_ACTION"})
    assert names == ["FS_ACTION", *["NEW_NAME"] * 4]
    assert reads.missing == ("NEW_NAME",)
    assert not reads.reading
    assert reads.due(1.5) == ""
    assert reads.due(4.0) == "NEW_NAME"
    reads.take("NEW_NAME", 2.0)
    assert reads.missing == ()


def test_nothing_waits_for_what_is_read_later():
    reads = ParameterReads()
    reads.begin(["FS_ACTION"], later=["BTN0_FUNCTION"])
    assert read(reads, 0.25) == ["FS_ACTION"] * 4 + ["BTN0_FUNCTION"]
    assert not reads.reading
    assert reads.missing == ("FS_ACTION",)
    reads.take("BTN0_FUNCTION", 33.0)
    assert reads.values == {"BTN0_FUNCTION": 33.0}


def test_an_older_name_answers_for_the_present_one():
    reads = ParameterReads()
    reads.begin(["MAV_GCS_SYSID"], OLDER_NAMES)
    assert set(read(reads, 2.0, answers={"SYSID_MYGCS"})) == {"MAV_GCS_SYSID", "SYSID_MYGCS"}
    assert reads.values == {"MAV_GCS_SYSID": 1.0}
    assert reads.missing == ()


def test_a_flood_of_parameters_is_left_out():
    reads = ParameterReads()
    reads.begin(["FS_ACTION"])
    for number in range(100_000):
        reads.take(f"P{number}", 1.0)
    for value in (math.nan, math.inf, 1e30):
        reads.take("FS_ACTION", value)
    assert reads.values == {}


def parameter(value, kind):
    packed = FramePacker(1, 1).pack("PARAM_VALUE", param_id="A", param_value=value, param_type=kind)
    return FrameParser().feed(packed)[0]


def test_a_value_is_the_32_bit_float_that_came():
    value = parameter_value(parameter(0.1, 9), bytewise=False)
    assert value == struct.unpack("<f", struct.pack("<f", 0.1))[0]
    assert value != 0.1
    assert parameter_value(parameter(-3.0, 6), bytewise=False) == -3.0


@pytest.mark.parametrize(
    ("form", "kind", "whole"),
    [("<i", 6, -3), ("<i", 6, 2_000_000), ("<I", 5, 7), ("<hxx", 4, -2), ("<Bxxx", 1, 255)],
)
def test_whole_numbers_may_come_as_bytes(form, kind, whole):
    (value,) = struct.unpack("<f", struct.pack(form, whole))
    assert parameter_value(parameter(value, kind), bytewise=True) == whole
