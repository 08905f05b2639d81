"""Surfaces that no tool should write."""

import math
import os
import random
import shutil
import time

from bakes import BAD_INPUT, DONE, FAILED, PROGRAM, hold
from refusals import controls, ended, hold_refusal, in_pairs


def sphere(rings, radius=0.3):
    """Vertices and triangles of a closed surface."""
    vertices, triangles = [(0.0, radius, 0.0)], []
    for i in range(1, rings):
        for k in range(2 * rings):
            a, b = math.pi * i / rings, math.pi * k / rings
            vertices.append((radius * math.sin(a) * math.cos(b), radius * math.cos(a),
                             radius * math.sin(a) * math.sin(b)))
    vertices.append((0.0, -radius, 0.0))
    at = lambda i, k: 1 + (i - 1) * 2 * rings + k % (2 * rings)
    for k in range(2 * rings):
        triangles += [(0, at(1, k + 1), at(1, k)), (len(vertices) - 1, at(rings - 1, k), at(rings - 1, k + 1))]
        for i in range(1, rings - 1):
            triangles += [(at(i, k), at(i, k + 1), at(i + 1, k)), (at(i + 1, k), at(i, k + 1), at(i + 1, k + 1))]
    return vertices, triangles


def good(vertices, triangles):
    return vertices, triangles


def opened(vertices, triangles):
    keep = random.sample(triangles, max(1, len(triangles) - random.randint(1, len(triangles) // 2)))
    return vertices, keep


def crossed(vertices, triangles):
    far = random.uniform(0.01, 0.5)
    n = len(vertices)
    return (vertices + [(x + far, y, z) for x, y, z in vertices],
            triangles + [(a + n, b + n, c + n) for a, b, c in triangles])


def flat(vertices, triangles):
    height = random.choice((0.0, 1e-30, 1e-9, 1e-4))
    return [(x, y * height, z) for x, y, z in vertices], triangles


def doubled(vertices, triangles):
    return vertices, triangles + random.choices(triangles, k=random.randint(1, len(triangles)))


def stacked(vertices, triangles):
    here = random.choice(vertices)
    return [here if random.random() < 0.3 else v for v in vertices], triangles


def odd_numbers(vertices, triangles):
    odd = lambda x: random.choice((math.nan, math.inf, -math.inf, 1e300, 1e39, -1e-320, 0.0, x)) \
        if random.random() < 0.02 else x
    return [tuple(odd(x) for x in v) for v in vertices], triangles


def scaled(vertices, triangles):
    factor = 10.0 ** random.uniform(-12, 12)
    return [tuple(factor * x for x in v) for v in vertices], triangles


def slivers(vertices, triangles):
    factor = 10.0 ** random.uniform(-7, -2)
    return [(x, y, z * factor) for x, y, z in vertices], triangles


def turned(vertices, triangles):
    return vertices, [t if random.random() < 0.5 else t[::-1] for t in triangles]


def beyond(vertices, triangles):
    pick = lambda: random.choice((0, 1, len(vertices), 2 ** 31 - 1, 2 ** 32, 10 ** 30))
    return vertices, [t if random.random() < 0.95 else (t[0], t[1], pick()) for t in triangles]


def torn(vertices, triangles):
    return [tuple(x + random.uniform(-0.1, 0.1) for x in v) for v in vertices], triangles


def few(vertices, triangles):
    count = random.randint(0, 3)
    return vertices, triangles[:count]


SURFACES = (opened, crossed, flat, doubled, stacked, odd_numbers, scaled, slivers, turned, beyond, torn, few)


def obj_text(vertices, triangles):
    return "".join("v %r %r %r\n" % v for v in vertices) + \
        "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)


def try_surface(inputs):
    """(whether it was baked, what was said, the longest time) of one surface."""
    k, kind, surface, environment, folder = inputs
    os.makedirs(folder)
    path = os.path.join(folder, "%s-%d.obj" % (kind.__name__, k))
    with open(path, "w") as file:
        file.write(obj_text(*surface))
    # As fine as for a character it takes seconds, nearly all in the library that wraps: one in ten.
    options = ("--resolution", "500", *(() if k % 10 == 9 else ("--cage-detail", "20")))
    longest, text = 0.0, ""
    for command in (["inspect", path],
                    ["bake", path, "--end", "0.05", "--device", "cpu", "--threads", "1", "-o", folder + "/out"]):
        begin = time.monotonic()
        status, text = ended([PROGRAM, *command, *options],
                             {**environment, "FASCICLE_CACHE_DIR": os.path.join(folder, "cache")}, folder)
        longest = max(longest, time.monotonic() - begin)
        is_whole = status == DONE
        if not is_whole:
            hold_refusal(status, text, (FAILED, BAD_INPUT), (os.path.basename(path), "mesh", "body"))
    shutil.rmtree(folder)
    return is_whole, text, longest


def surfaces(bakes, count):
    """Surfaces that are open, crossed, flat, doubled, stacked, torn, inside out, huge, tiny, of slivers, of odd numbers
    or of vertices that are not there, through `inspect` and `bake`: baked, or refused with one message that says what
    to do; what takes more than 10 s says that it is at work."""
    root = bakes[0].empty_folder()
    environment = bakes[0].environment()
    controls(environment, root)

    def drawn():
        for k in range(count):
            # The first is a surface that nothing is wrong with: what refuses all of them is found out.
            kind = SURFACES[k % len(SURFACES)] if k > 0 else good
            surface = kind(*sphere(random.randint(2, 9)))
            if k > 0 and random.random() < 0.2:
                surface = random.choice(SURFACES)(*surface) if surface[1] else surface
            yield k, kind, surface, environment, os.path.join(root, str(k))

    baked, longest = 0, 0.0
    for k, (is_whole, text, seconds) in enumerate(in_pairs(try_surface, drawn())):
        hold(is_whole or k > 0, "a sphere was refused: " + text)
        baked, longest = baked + is_whole, max(longest, seconds)
    refused = count - baked
    hold(count < 50 or (baked and refused), "%d were baked and %d refused: the surfaces are all of one kind"
         % (baked, refused))
    shutil.rmtree(root)
    return "%d surfaces: %d baked, %d refused with one message; no crash, no hang, %.0f s at most" \
        % (count, baked, refused, longest)
