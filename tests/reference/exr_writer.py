"""Writes scan-line OpenEXR files: 32-bit float, ZIP. (Mitsuba's own writer compresses with PIZ, which
few small readers know, and gains nothing on noisy variances.)"""

import struct
import zlib

import numpy as np

LINES_PER_BLOCK = 16  # What the format lays down for ZIP.


def attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


def compressed(raw):
    """ZIP as in OpenEXR: even and odd bytes apart, differences, deflate; raw where that is no shorter."""
    data = np.frombuffer(raw, np.uint8)
    data = np.concatenate([data[0::2], data[1::2]]).astype(np.int16)
    data[1:] = data[1:] - data[:-1] + 128
    packed = zlib.compress((data & 255).astype(np.uint8).tobytes(), 9)
    return packed if len(packed) < len(raw) else raw


def write_exr(path, channels, metadata):
    """`channels`: name to (height, width) array; `metadata`: name to text."""
    names = sorted(channels)  # The format's order, in the header and in every line.
    height, width = channels[names[0]].shape
    layers = np.stack([channels[name] for name in names], axis=1).astype("<f4")  # line, channel, pixel
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for name in names)
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<II", 20000630, 2)
    header += attribute("channels", "chlist", listed + b"\0")
    header += attribute("compression", "compression", b"\3")
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0))
    for name, text in metadata.items():
        header += attribute(name, "string", str(text).encode())
    header += b"\0"
    blocks = []
    for first in range(0, height, LINES_PER_BLOCK):
        data = compressed(layers[first : first + LINES_PER_BLOCK].tobytes())
        blocks.append(struct.pack("<ii", first, len(data)) + data)
    ends = len(header) + 8 * len(blocks) + np.cumsum([0] + [len(block) for block in blocks[:-1]])
    with open(path, "wb") as file:
        file.write(header + ends.astype("<u8").tobytes() + b"".join(blocks))
