"""Experiments that cost nothing, for the machinery that runs, keeps and reports them."""

import struct
import zlib

from skillfold.experiments.rows import Row
from skillfold.viewing.reproduced.result import Experiment, Picture, Result


def png(shade):
    """A picture of two times one grey pixels."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 2, 1, 8, 0, 0, 0, 0)
    body = zlib.compress(bytes([0, shade, shade]))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


class Counted:
    """An experiment that keeps what it was called with; `raises` is raised instead of an answer."""

    def __init__(self, name, measured=0.5, note="", raises=None):
        self.name, self.measured, self.note, self.raises = name, measured, note, raises
        self.calls = []

    def __call__(self, settings, folder):
        self.calls.append(settings)
        settings.progress("trying", 0.5)
        if self.raises is not None:
            raise self.raises
        file = folder / f"{self.name}.png"
        file.write_bytes(png(settings.seed % 256))
        rows = [
            Row(f"{self.name} reached", self.measured, "share", 0.9, ">=", paper="0.95", note=self.note),
            Row("beside", 12345.0, "N"),
            Row("fast", 1.25, "ms", 2.0, "<"),
            Row("absent", None, "s", 1.0, note="no data"),
            Row("endless", float("inf"), "s", 1.0),
        ]
        return Result(rows, [Picture(file, "figures 2 and 3", f"What {self.name} shows.")])

    def experiment(self):
        return Experiment(f"Section I: {self.name}", "000", self, (f"{self.name} has other weights.",))


def experiments(*names, **options):
    """The experiments by name, and what each was called with by name."""
    made = {name: Counted(name, **options.get(name.replace("-", "_"), {})) for name in names}
    return {name: counted.experiment() for name, counted in made.items()}, made
