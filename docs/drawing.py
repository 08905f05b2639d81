"""Pictures with Python's standard library alone: shaded triangles, PNG, and SVG with curves.

Pictures of bars are rasterised here (flat shading, depth buffer) and embedded in the SVG as PNG; curves and text are
vectors. Stills of characters come from `fascicle render` and are put side by side.
"""
import base64
import math
import struct
import zlib

GRID, PALE = "#e4e4e4", "#f4f4f4"


class Canvas:
    """A depth-buffered picture at twice its displayed size."""

    def __init__(self, width, height):
        self.w, self.h = 2 * width, 2 * height
        self.pixels = bytearray(b"\xff" * (3 * self.w * self.h))
        self.depth = [-1e30] * (self.w * self.h)

    def triangle(self, corners, color):
        (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = corners
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if abs(area) < 1e-9:
            return
        rgb = bytes(max(0, min(255, round(255 * c))) for c in color)
        for y in range(max(0, math.ceil(min(y0, y1, y2))), min(self.h - 1, math.floor(max(y0, y1, y2))) + 1):
            for x in range(max(0, math.ceil(min(x0, x1, x2))), min(self.w - 1, math.floor(max(x0, x1, x2))) + 1):
                b = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
                c = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
                if b < -1e-6 or c < -1e-6 or b + c > 1 + 1e-6:
                    continue
                z = z0 + b * (z1 - z0) + c * (z2 - z0)
                at = y * self.w + x
                if z > self.depth[at]:
                    self.depth[at] = z
                    self.pixels[3 * at:3 * at + 3] = rgb

    def rows(self):
        return [bytes(self.pixels[3 * self.w * y:3 * self.w * (y + 1)]) for y in range(self.h)]


def png(rows):
    """Encodes a picture whose rows are RGB bytes."""
    above, packed = bytes(len(rows[0])), b""
    for row in rows:
        packed += b"\2" + bytes((a - b) & 255 for a, b in zip(row, above))  # filter 2: minus the row above, which compresses better
        above = row
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(packed, 9)) + chunk(b"IEND", b""))


def read_png(path):
    """The rows, as RGB bytes, of a PNG with 8 bits a channel, RGB or RGBA, not interlaced."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">2I5B", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    assert depth == 8 and color in (2, 6) and not interlaced, path
    pixel = 3 if color == 2 else 4
    raw, rows, above = zlib.decompress(packed), [], bytearray(pixel * width)
    for y in range(height):
        start = y * (pixel * width + 1)
        row = bytearray(raw[start + 1:start + 1 + pixel * width])
        for x in range(pixel * width) if raw[start] else ():
            left, up = (row[x - pixel] if x >= pixel else 0), above[x]
            corner = above[x - pixel] if x >= pixel else 0
            guess = left + up - corner
            nearest = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            row[x] = (row[x] + {1: left, 2: up, 3: (left + up) // 2, 4: nearest}[raw[start]]) & 255
        above = row
        rows.append(bytes(row) if pixel == 3 else b"".join(row[i:i + 3] for i in range(0, len(row), 4)))
    return rows


def beside(pictures):
    return [b"".join(rows) for rows in zip(*pictures)]


def crop(rows, box):
    """`box`: left, top, right, bottom in pixels."""
    left, top, right, bottom = box
    return [row[3 * left:3 * right] for row in rows[top:bottom]]


def sub(a, b):
    return tuple(p - q for p, q in zip(a, b))


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a)) or 1.0
    return tuple(p / length for p in a)


VIEW = unit((0.42, 0.28, 1.0))
RIGHT = unit(cross((0, 1, 0), VIEW))
UP = cross(VIEW, RIGHT)
LIGHT = unit((0.3, 0.9, 0.7))


def draw(canvas, points, triangles, colors, scale, at):
    """`at` is the pixel of the world's origin, `scale` pixels per metre."""
    for t in triangles:
        a, b, c = (points[i] for i in t)
        normal = unit(cross(sub(b, a), sub(c, a)))
        if dot(normal, VIEW) <= 0:
            continue
        shade = 0.55 + 0.45 * max(0.0, dot(normal, LIGHT))
        corners = [(2 * (at[0] + scale * dot(p, RIGHT)), 2 * (at[1] - scale * dot(p, UP)), dot(p, VIEW)) for p in (a, b, c)]
        canvas.triangle(corners, tuple(shade * k for k in colors(t)))


def banded(rest, base, axis, period):
    """Alternating tones along the rest shape, which make stretch visible."""
    def color(t):
        middle = sum(rest[i][axis] for i in t) / 3
        return base if int(middle / period) % 2 == 0 else tuple(0.82 * k for k in base)
    return color


def svg(width, height, body):
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="14" fill="#222">\n'
            f'<rect width="{width}" height="{height}" fill="#fff"/>\n{body}</svg>\n')


def image(canvas, x, y):
    data = base64.b64encode(png(canvas.rows())).decode()
    return f'<image x="{x}" y="{y}" width="{canvas.w // 2}" height="{canvas.h // 2}" href="data:image/png;base64,{data}"/>\n'


def text(x, y, words, anchor="middle", **more):
    style = "".join(f' {key.replace("_", "-")}="{value}"' for key, value in more.items())
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}"{style}>{words}</text>\n'


class Plot:
    """Curves over time: `box` is left, top, width, height in pixels; values from `low` (the bottom) to `high`."""

    def __init__(self, box, end, low, high):
        (self.left, self.top, self.w, self.h), self.end, self.low, self.high = box, end, low, high
        self.body = ""

    def x(self, time):
        return self.left + self.w * time / self.end

    def y(self, value):
        return self.top + self.h * (self.high - value) / (self.high - self.low)

    def grid(self, values, label):
        """A line and a label for each of the values, and for each half second."""
        bottom = self.top + self.h
        for k in range(int(2 * self.end) + 1):
            self.body += f'<line x1="{self.x(k / 2)}" x2="{self.x(k / 2)}" y1="{self.top}" y2="{bottom}" stroke="{GRID}"/>\n'
            self.body += text(self.x(k / 2), bottom + 18, f"{k / 2:g} s")
        for v in values:
            self.body += f'<line x1="{self.left}" x2="{self.left + self.w}" y1="{self.y(v)}" y2="{self.y(v)}" stroke="{GRID}"/>\n'
            self.body += text(self.left - 8, self.y(v) + 5, label(v), "end")

    def shade(self, begin, words):
        self.body += (f'<rect x="{self.x(begin)}" y="{self.top}" width="{self.w * (self.end - begin) / self.end}" height="{self.h}" '
                      f'fill="{PALE}"/>\n')
        self.body += text(self.x((begin + self.end) / 2), self.top + self.h - 8, words, font_size=12)

    def curve(self, points, ink):
        places = " ".join(f"{self.x(t):.1f},{self.y(v):.1f}" for t, v in points)
        self.body += f'<polyline points="{places}" fill="none" stroke="{ink}" stroke-width="2"/>\n'

    def label(self, x, words, ink):
        self.body += text(x, self.top - 10, words, fill=ink, font_weight="bold")

    def title(self, words):
        self.body += text(self.left + self.w, self.top - 10, words, "end", font_size=12)
