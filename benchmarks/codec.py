"""What coding costs: messages to bytes and back, pictures to run lengths and back."""

from __future__ import annotations

import timeit
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from benchmarks.figures import median_ms, report
from hub.gcm import navigation, rle, vision


def robot_state() -> navigation.RobotState:
    ranges = np.linspace(0.2, 4.0, navigation.SENSOR_COUNT, dtype=np.float32)
    return navigation.RobotState(
        stamp=1e9,
        x=1.0,
        y=2.0,
        theta=0.5,
        linear=0.3,
        angular=0.1,
        commanded_linear=0.3,
        commanded_angular=0.1,
        sonar=ranges,
        infrared=ranges,
        bumpers=0,
        battery_voltage=24.0,
        battery_fraction=0.8,
        motion=navigation.MotionState.MOVING,
        refused=0,
    )


def image(data: npt.NDArray[np.uint8]) -> vision.Image:
    camera = vision.CameraState(
        stamp=1e9,
        pan=0.0,
        tilt=0.0,
        zoom=0.0,
        horizontal_fov=0.8,
        vertical_fov=0.6,
        mount_forward=0.1,
        mount_height=0.4,
        pan_limit=1.7,
        tilt_limit=0.4,
        slewing=0,
    )
    return vision.Image(
        camera=camera,
        coding=vision.ImageCoding.RLE,
        width_px=160,
        height_px=120,
        channels=3,
        length=len(data),
        data=data,
    )


def natural_picture() -> npt.NDArray[np.uint8]:
    """A room as a camera sees it, with a rough poster and the sensor's noise; (120, 160, 3)."""
    random = np.random.default_rng(5)
    rows, columns = np.mgrid[0:120, 0:160]
    floor = rows > 55
    shade = np.where(floor, 60 + rows, 190 - np.abs(columns - 80) * 0.5)
    picture = shade[..., None] * np.where(floor[..., None], (0.9, 0.8, 0.6), (0.8, 0.85, 0.9))
    for left, top, width, height, colour in (
        (20, 40, 30, 40, (150, 60, 40)),
        (90, 50, 24, 22, (40, 90, 150)),
        (120, 30, 8, 60, (70, 70, 70)),
    ):
        picture[top : top + height, left : left + width] = colour
    picture[10:40, 60:90] += random.normal(0.0, 8.0, (30, 30, 1))
    picture += random.normal(0.0, 0.3, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8)


def microseconds(work: Callable[[], object], calls: int = 2000) -> float:
    """Median over runs of many calls; one call is too short for the clock [us]."""
    times = sorted(timeit.repeat(work, number=calls, repeat=15))
    return times[len(times) // 2] / calls * 1e6


def main() -> None:
    state, state_of = robot_state(), navigation.ROBOT_STATE
    payload = b"".join(state_of.encode(state))
    there = microseconds(lambda: b"".join(state_of.encode(state)))
    back = microseconds(lambda: state_of.decode(payload))
    note = f"encode {there:.2f}, decode {back:.2f}; {len(payload)} bytes"
    report("codec.state_us", there + back, "us", bar=3, note=note)

    picture = natural_picture()
    shot = image(picture.reshape(-1))
    payload = b"".join(vision.IMAGE.encode(shot))
    there = microseconds(lambda: b"".join(vision.IMAGE.encode(shot)), 200)
    back = microseconds(lambda: vision.IMAGE.decode(payload), 200)
    note = f"encode {there:.2f}, decode {back:.2f}; {len(payload)} bytes"
    report("codec.image_us", there + back, "us", bar=15, note=note)

    for quality, which in ((60, ""), (100, "_exact")):
        coded = rle.encode(picture, quality=quality)
        note = f"quality {quality}: {len(coded)} of {picture.size} bytes"
        value = median_ms(lambda _, q=quality: rle.encode(picture, quality=q), 300)
        report(f"rle.image{which}_encode_ms", value, "ms", bar=0.4, note=note)
        value = median_ms(lambda _, c=coded: rle.decode(c, 120, 160, 3), 300)
        report(f"rle.image{which}_decode_ms", value, "ms", bar=0.3, note=note)


if __name__ == "__main__":
    main()
