#!/usr/bin/env python3
"""Writes jacksboro.tif, the real terrain of the ecosystem examples, from matplotlib's sample data.

    pip install matplotlib
    python make_jacksboro.py            write jacksboro.tif beside this file
    python make_jacksboro.py --check    fail when the committed file differs

The elevations are taken as they are: 344 rows of 403 cells of 3 seconds of arc, first row north,
whole metres as 16-bit integers. The file is an uncompressed GeoTIFF (EPSG:4326, PixelIsArea), so
that the same bytes come out whatever the versions of the tools. See jacksboro.NOTICE.txt.
"""

import ast
import importlib.util
import pathlib
import struct
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
TARGET = HERE / "jacksboro.tif"
SAMPLE = "mpl-data/sample_data/jacksboro_fault_dem.npz"
DESCRIPTION = b"Jacksboro fault, Tennessee: elevation in metres\0"


def sample_path():
    """Where the installed matplotlib package keeps the sample."""
    spec = importlib.util.find_spec("matplotlib")
    if spec is None:
        sys.exit("matplotlib is not installed: pip install matplotlib")
    return pathlib.Path(spec.origin).parent / SAMPLE


def arrays(path):
    """The arrays of an .npz file as {name: (type, shape, bytes)}."""
    found = {}
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            if data[:6] != b"\x93NUMPY":
                sys.exit(f"{name} is no array")
            size, start = (struct.unpack("<H", data[8:10])[0], 10) if data[6] == 1 else (struct.unpack("<I", data[8:12])[0], 12)
            header = ast.literal_eval(data[start : start + size].decode("latin-1"))
            found[name.removesuffix(".npy")] = (header["descr"], header["shape"], data[start + size :])
    return found


def number(entry):
    """The value of an array without dimensions."""
    kind, _, data = entry
    return struct.unpack({"<f8": "<d", "<f4": "<f"}[kind], data)[0]


def geotiff(width, height, samples, west, north, cell):
    """An uncompressed little-endian GeoTIFF of one strip of 16-bit integers."""
    short, long, double, text = 3, 4, 12, 2
    keys = [1, 1, 0, 4, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326, 2054, 0, 1, 9102]
    tags = [
        (256, long, 1, struct.pack("<I", width)),
        (257, long, 1, struct.pack("<I", height)),
        (258, short, 1, struct.pack("<H", 16)),
        (259, short, 1, struct.pack("<H", 1)),
        (262, short, 1, struct.pack("<H", 1)),
        (270, text, len(DESCRIPTION), DESCRIPTION),
        (273, long, 1, struct.pack("<I", 8)),
        (277, short, 1, struct.pack("<H", 1)),
        (278, long, 1, struct.pack("<I", height)),
        (279, long, 1, struct.pack("<I", len(samples))),
        (339, short, 1, struct.pack("<H", 2)),
        (33550, double, 3, struct.pack("<3d", cell, cell, 0.0)),
        (33922, double, 6, struct.pack("<6d", 0.0, 0.0, 0.0, west, north, 0.0)),
        (34735, short, len(keys), struct.pack(f"<{len(keys)}H", *keys)),
    ]
    directory = 8 + len(samples)
    tail_at = directory + 2 + 12 * len(tags) + 4
    entries, tail = b"", b""
    for tag, kind, count, data in tags:
        if len(data) > 4:
            data, tail = struct.pack("<I", tail_at + len(tail)), tail + data + b"\0" * (len(data) % 2)
        entries += struct.pack("<HHI", tag, kind, count) + data.ljust(4, b"\0")
    head = struct.pack("<2sHI", b"II", 42, directory)
    return head + samples + struct.pack("<H", len(tags)) + entries + struct.pack("<I", 0) + tail


def main():
    data = arrays(sample_path())
    kind, (height, width), samples = data["elevation"]
    cell, west = number(data["dx"]), number(data["xmin"])
    # In the sample `ymin` is the latitude of the first row's northern edge.
    north = max(number(data["ymin"]), number(data["ymax"]))
    if kind != "<i2" or len(samples) != 2 * width * height or abs(cell - number(data["dy"])) > 1e-12:
        sys.exit("the sample is not as expected")
    made = geotiff(width, height, samples, west, north, cell)
    if "--check" in sys.argv[1:]:
        if made != TARGET.read_bytes():
            sys.exit(f"{TARGET.name} differs from what the sample gives")
        print(f"{TARGET.name} is what the sample gives")
    else:
        TARGET.write_bytes(made)
        print(f"{TARGET.name}: {width} × {height} cells, {len(made)} bytes")


if __name__ == "__main__":
    main()
