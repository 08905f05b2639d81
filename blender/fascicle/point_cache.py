"""surface.pc2: Point Cache 2, and its parts for the objects of a character. Knows nothing of Blender."""

import os
import struct

from .problem import Problem

HEAD = struct.Struct("<12siiffi")
POINT = 12  # bytes: three floats


def read_head(file, path):
    """(points, samples). Raises Problem where the file is not what its head says."""
    head = file.read(HEAD.size)
    if len(head) == HEAD.size:
        magic, version, points, _, _, samples = HEAD.unpack(head)
        size = os.fstat(file.fileno()).st_size
        if magic == b"POINTCACHE2\0" and version == 1 and points > 0 and size == HEAD.size + points * samples * POINT:
            return points, samples
    raise Problem("%s is no whole point cache; bake again" % path)


def samples(path):
    """The bytes of each sample: three little-endian floats a point."""
    with open(path, "rb") as file:
        points, count = read_head(file, path)
        for _ in range(count):
            yield file.read(points * POINT)


def write_parts(path, parts):
    """Cuts the cache into one for each (path, points) of `parts`, in this order, byte by byte."""
    with open(path, "rb") as file:
        points, count = read_head(file, path)
        if points != sum(size for _, size in parts):
            raise Problem("%s has %d vertices; the character has %d" % (path, points, sum(size for _, size in parts)))
        outputs = [open(name, "wb") for name, _ in parts]
        try:
            for output, (_, size) in zip(outputs, parts):
                output.write(HEAD.pack(b"POINTCACHE2\0", 1, size, 0.0, 1.0, count))
            for _ in range(count):
                for output, (_, size) in zip(outputs, parts):
                    output.write(file.read(size * POINT))
        finally:
            for output in outputs:
                output.close()
