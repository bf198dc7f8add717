"""What pictures cost: bytes by coding and noise, and the time to make them, also from a video."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.figures import median_ms, report, say
from hub.errors import CameraError
from hub.gcm.vision import ImageCoding, NightCommand
from hub.ipc.transport.heap import keep_heap
from hub.modules.vision.coding import code
from hub.modules.vision.night import NightMode
from hub.modules.vision.picture import brightened, brightness
from hub.robots.video_camera import VideoCamera
from hub.sim.arena import load_arena
from hub.sim.spatial_pose import SpatialPose
from tests.hub.sim.arenas import free_poses
from tests.support.magellan import magellan_camera

POSES = 40
QUALITY = 60
SIZES = ((160, 120), (320, 240))
NOISE = 4.0
"""Standard deviation of the noise of a small real camera indoors [levels]."""

Pixels = npt.NDArray[np.uint8]


def pictures(width_px: int, height_px: int, noise: float) -> list[Pixels]:
    """What the camera sees at many places of the yellow arena, the same in every run."""
    arena = load_arena("yellow")
    camera, random = magellan_camera(arena), np.random.default_rng(5)
    made = []
    for pose in free_poses(arena, POSES, 2003, 0.0, 10.0):
        camera.place(SpatialPose().at(pose))
        pixels = camera.capture(width_px, height_px)
        if noise:
            noisy = pixels + random.normal(0.0, noise, pixels.shape)
            pixels = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
        made.append(pixels)
    return made


def report_codings() -> None:
    for width, height in SIZES:
        for noise in (0.0, NOISE):
            shown = pictures(width, height, noise)
            sort = "noisy" if noise else "clean"
            for coding in ImageCoding:
                name = f"vision.{coding.name.lower()}_{width}x{height}_{sort}"
                lengths = [len(code(pixels, coding, QUALITY)) for pixels in shown]
                note = f"colour, quality {QUALITY}, mean of {POSES} places, noise of {noise:g}"
                report(f"{name}_kB", float(np.mean(lengths)) / 1e3, "kB", note=note)
                if coding is not ImageCoding.RAW:
                    value = median_ms(
                        lambda n, c=coding, s=shown: code(s[n % POSES], c, QUALITY), POSES
                    )
                    report(f"{name}_ms", value, "ms", note="to code one picture")


def report_night() -> None:
    """A picture of the dark arena, from the rays to the brightened pixels."""
    arena = load_arena("yellow")
    poses = free_poses(arena, POSES, 2003, 0.0, 10.0)
    camera, night = magellan_camera(arena, light=0.04), NightMode()
    night.command(NightCommand(on=1))
    camera.set_headlight(1.0)

    def picture(number: int) -> None:
        pose = poses[number % POSES]
        camera.place(SpatialPose().at(pose))
        pixels = camera.take(320, 240, float(number)).pixels
        brightened(pixels, night.see(brightness(pixels), float(number)))

    note = "with headlight, noise and gain; beside sim.picture_320x240_ms"
    report("vision.night_320x240_ms", median_ms(picture, 200), "ms", note=note)


def report_video() -> None:
    """A file of 720p at 25 pictures a second stands for a camera."""
    try:
        import av
    except ImportError:
        report("vision.video_take_320x240_ms", None, "ms", note="PyAV is not installed")
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mkv"
        with av.open(str(path), "w") as container:
            stream = container.add_stream("mjpeg", rate=25)
            stream.width, stream.height, stream.pix_fmt = 1280, 720, "yuvj420p"
            for pixels in pictures(320, 240, NOISE):
                large = np.repeat(np.repeat(pixels[:180], 4, axis=0), 4, axis=1)
                container.mux(stream.encode(av.VideoFrame.from_ndarray(large, format="rgb24")))
            container.mux(stream.encode())
        source = str(path)
        with closing(VideoCamera(source, horizontal_fov=1.0, forward=0.0, height=0.3)) as camera:
            until_pictures_come(camera)
            value = median_ms(lambda _: camera.take(320, 240, 0.0), 100)
            report("vision.video_take_320x240_ms", value, "ms", note="from 1280x720, area mean")
            share = processor_share(2.0)
            note = "of one core: decoding MJPEG of 1280x720 at 25 a second, nobody asks"
            report("vision.video_idle_cpu", share, "", note=note)


def until_pictures_come(camera: VideoCamera) -> None:
    for _ in attempts(10.0):
        try:
            camera.take(1, 1, 0.0)
        except CameraError as error:
            why = error
        else:
            return
    raise why


def attempts(seconds: float) -> Iterator[None]:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield
        time.sleep(0.02)


def processor_share(seconds: float) -> float:
    """Processor time that this process takes while it only waits."""
    before, began = time.process_time(), time.monotonic()
    time.sleep(seconds)
    return (time.process_time() - before) / (time.monotonic() - began)


def main() -> None:
    keep_heap()  # as every module's client does
    say("pictures of the yellow arena in every coding")
    report_codings()
    report_night()
    report_video()


if __name__ == "__main__":
    main()
