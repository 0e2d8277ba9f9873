"""Pictures into a file that moves (`.gif`, `.mp4`) or into a folder of PNG files."""

from collections.abc import Iterable
from pathlib import Path
from shutil import which
from typing import Any

from skillfold.errors import InputError

KINDS = (".gif", ".mp4")


def check_video(path: Path) -> Path:
    """The path, if pictures can be written there.

    Raises:
        InputError: an ending that is not known, or ffmpeg is missing.
    """
    kind = path.suffix.lower()
    if kind and kind not in KINDS:
        raise InputError(f"{path}: ends in {kind}; possible: {', '.join(KINDS)}, or a folder for PNG files.")
    if kind == ".mp4" and which("ffmpeg") is None:
        raise InputError(f"{path}: .mp4 needs ffmpeg, which is not installed; name a .gif or a folder instead.")
    return path


def write_video(path: Path, pictures: Iterable[Any], rate: float) -> int:
    """Write pictures (height, width, 3), `rate` a second; how many there were.

    Raises:
        InputError: the file cannot be written.
    """
    kind = check_video(path).suffix.lower()
    try:
        return {".gif": _gif, ".mp4": _mp4, "": _folder}[kind](path, pictures, rate)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}.") from None


def _gif(path: Path, pictures: Iterable[Any], rate: float) -> int:
    from PIL import Image

    frames = [Image.fromarray(picture).quantize(128) for picture in pictures]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=round(1000 / rate), loop=0)
    return len(frames)


def _folder(path: Path, pictures: Iterable[Any], rate: float) -> int:
    from PIL import Image

    path.mkdir(parents=True, exist_ok=True)
    count = 0
    for picture in pictures:
        Image.fromarray(picture).save(path / f"{count:05d}.png")
        count += 1
    return count


def _mp4(path: Path, pictures: Iterable[Any], rate: float) -> int:
    """Through ffmpeg, by a pipe."""
    from subprocess import DEVNULL, PIPE, Popen

    count, process = 0, None
    for picture in pictures:
        if process is None:
            size = f"{picture.shape[1]}x{picture.shape[0]}"
            source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", f"{rate:g}", "-i", "-"]
            command = ["ffmpeg", "-y", "-loglevel", "error", *source, "-pix_fmt", "yuv420p", str(path)]
            process = Popen(command, stdin=PIPE, stderr=DEVNULL)
        process.stdin.write(picture.tobytes())  # type: ignore[union-attr]
        count += 1
    if process is not None:
        process.communicate()
        if process.returncode:
            raise OSError(f"ffmpeg failed with code {process.returncode}")
    return count
