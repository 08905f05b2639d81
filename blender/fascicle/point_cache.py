"""surface.pc2: Point Cache 2, and its parts for the objects of a character. Knows nothing of Blender."""

import os
import re
import struct

from .problem import Problem

NAME = "surface.pc2"
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


def part_name(number):
    return "object-%d.pc2" % number


def is_part_name(name):
    return re.fullmatch(r"object-\d+\.pc2", name) is not None


def parts_in(folder):
    """The names of the parts into which the folder's cache was cut; empty where such files are not those parts."""
    names, left = [], 0
    try:
        with open(os.path.join(folder, NAME), "rb") as file:
            left, count = read_head(file, file.name)
        while left > 0:
            names.append(part_name(len(names)))
            with open(os.path.join(folder, names[-1]), "rb") as file:
                points, found = read_head(file, file.name)
            if found != count:
                return []
            left -= points
    except (OSError, Problem):
        return []
    return names if left == 0 else []


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
