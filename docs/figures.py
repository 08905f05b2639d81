#!/usr/bin/env python3
"""Bakes the built-in scenes and draws docs/figures/figure-{6,7,8}.svg, figure-9.png and lag.svg.

    python3 docs/figures.py build/release/fascicle [CHARACTER.glb CLIP]

With a character, the lag of its clip's flesh is drawn too, in lag-character.svg.

Only Python's standard library is used. Pictures of bars are rasterised here (flat shading, depth buffer) and stand inside
the SVG as PNG; curves and words are vectors. The bear is drawn by `fascicle render`.
"""
import base64
import csv
import json
import math
import os
import struct
import subprocess
import sys
import zlib

OUT = "out/figures"
MUSCLE, FAT, SINGLE = (0.74, 0.24, 0.22), (0.93, 0.76, 0.42), (0.45, 0.58, 0.78)


def bake(program, name, folder=None, more=()):
    folder = os.path.join(OUT, folder or name)
    subprocess.run([program, "bake", name, "-o", folder, "--format", "pc2", "--device", "cpu", "--overwrite", "-q", *more],
                   check=True, stdout=subprocess.DEVNULL)
    return folder


def read_bake(folder):
    rest, triangles = [], []
    for line in open(os.path.join(folder, "rest.obj"), encoding="utf-8"):
        words = line.split()
        if words[:1] == ["v"]:
            rest.append(tuple(map(float, words[1:4])))
        elif words[:1] == ["f"]:
            triangles.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:4]))
    with open(os.path.join(folder, "surface.pc2"), "rb") as file:
        header = struct.unpack("<12siiffi", file.read(32))
        count, samples = header[2], header[5]
        data = file.read()
    frame = lambda k: [struct.unpack_from("<3f", data, 12 * (k * count + i)) for i in range(count)]
    with open(os.path.join(folder, "metrics.csv"), encoding="utf-8") as file:
        metrics = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    assert len(metrics) == samples, "metrics.csv and surface.pc2 count different frames"
    return {"rest": rest, "triangles": triangles, "frame": frame, "samples": samples, "metrics": metrics}


class Canvas:
    """A depth-buffered picture at twice the size it is shown at."""

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

    def png(self):
        above, rows = bytes(3 * self.w), b""
        for y in range(self.h):
            row = self.pixels[3 * self.w * y:3 * self.w * (y + 1)]
            rows += b"\2" + bytes((a - b) & 255 for a, b in zip(row, above))  # 2: less the row above, which packs better
            above = row
        chunk = lambda kind, body: (struct.pack(">I", len(body)) + kind + body +
                                    struct.pack(">I", zlib.crc32(kind + body)))
        return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", self.w, self.h, 8, 2, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


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
    """`at` is the pixel of the world's origin, `scale` pixels a metre."""
    for t in triangles:
        a, b, c = (points[i] for i in t)
        normal = unit(cross(sub(b, a), sub(c, a)))
        if dot(normal, VIEW) <= 0:
            continue
        shade = 0.55 + 0.45 * max(0.0, dot(normal, LIGHT))
        # Two-tone squares along the rest shape make the stretch visible.
        corners = [(2 * (at[0] + scale * dot(p, RIGHT)), 2 * (at[1] - scale * dot(p, UP)), dot(p, VIEW)) for p in (a, b, c)]
        canvas.triangle(corners, tuple(shade * k for k in colors(t)))


def banded(rest, base, axis, period):
    def color(t):
        middle = sum(rest[i][axis] for i in t) / 3
        return base if int(middle / period) % 2 == 0 else tuple(0.82 * k for k in base)
    return color


def svg(name, width, height, body):
    os.makedirs("docs/figures", exist_ok=True)
    path = f"docs/figures/{name}.svg"
    with open(path, "w", encoding="utf-8") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
                   f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="14" fill="#222">\n'
                   f'<rect width="{width}" height="{height}" fill="#fff"/>\n{body}</svg>\n')
    print(path)


def image(canvas, x, y):
    data = base64.b64encode(canvas.png()).decode()
    return (f'<image x="{x}" y="{y}" width="{canvas.w // 2}" height="{canvas.h // 2}" '
            f'href="data:image/png;base64,{data}"/>\n')


def text(x, y, words, anchor="middle", **more):
    style = "".join(f' {key.replace("_", "-")}="{value}"' for key, value in more.items())
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}"{style}>{words}</text>\n'


def tip_change(result):
    first, last = result["metrics"][0], result["metrics"][-1]
    return [last[f"tip_{c}"] - first[f"tip_{c}"] for c in "xyz"]


def length_of(result, axis):
    return max(p[axis] for p in result["rest"]) - min(p[axis] for p in result["rest"])


def figure_6(program):
    names = [("bar-hang-none", "no fibre"), ("bar-hang-across", "fibres across gravity"), ("bar-hang-along", "fibres along gravity")]
    results = [(label, read_bake(bake(program, name))) for name, label in names]
    length = length_of(results[0][1], 1)
    width, height, scale = 640, 470, 240 / length
    canvas, body, stretches = Canvas(width, height), "", {}
    for k, (label, r) in enumerate(results):
        x = 110 + 200 * k
        top = max(p[1] for p in r["rest"])
        place = lambda points: [(p[0], p[1] - top, p[2]) for p in points]
        draw(canvas, place(r["frame"](r["samples"] - 1)), r["triangles"], banded(r["rest"], SINGLE, 1, length / 10), scale, (x, 60))
        stretches[label] = -tip_change(r)[1] / length
    body += image(canvas, 0, 0)
    for k, (label, _) in enumerate(results):
        body += text(125 + 200 * k, 24, label) + text(125 + 200 * k, 42, f"stretch {100 * stretches[label]:.1f} %", font_weight="bold")
    svg("figure-6", width, height, body)
    return stretches


def figure_7(program):
    names = ["0", "0.6", "0.75", "1"]
    results = [(beta, read_bake(bake(program, f"bar-beta-{beta}"))) for beta in names]
    length = length_of(results[0][1], 0)
    width, height, scale = 900, 330, 185 / length
    canvas, body, drops = Canvas(width, height), "", {}
    for k, (beta, r) in enumerate(results):
        draw(canvas, r["frame"](r["samples"] - 1), r["triangles"], banded(r["rest"], SINGLE, 0, length / 10), scale, (52 + 222 * k, 130))
        drops[beta] = -tip_change(r)[1] / length
    body += image(canvas, 0, 0)
    for k, (beta, _) in enumerate(results):
        body += text(115 + 222 * k, 24, f"beta {beta}") + text(115 + 222 * k, 42, f"tip drops {drops[beta]:.2f} lengths", font_weight="bold")
    svg("figure-7", width, height, body)
    return drops


def figure_8(program):
    names = [("iwamoto", "Iwamoto et al.: beta 0, 0"), ("i", "(i): beta 1, 0.3"), ("ii", "(ii): other muscle fibres"), ("iii", "(iii): beta 1, 1")]
    inks = ["#888888", "#3465a4", "#4e9a06", "#cc0000"]
    results = [(label, read_bake(bake(program, f"bar-layers-{name}"))) for name, label in names]
    length = length_of(results[0][1], 0)
    width, height, scale = 960, 560, 180 / length
    canvas, body = Canvas(width, 300), ""
    half = length / 2
    for k, (label, r) in enumerate(results):
        swing = r["metrics"]
        lowest = min(range(len(swing)), key=lambda f: swing[f]["tip_y"])
        color = lambda t, r=r: MUSCLE if sum(r["rest"][i][0] for i in t) / 3 < half else FAT
        draw(canvas, r["frame"](lowest), r["triangles"], color, scale, (64 + 238 * k, 110))
    body += image(canvas, 0, 0)
    left, top, w, h = 60, 320, 860, 200
    seconds = 5.0
    shown = [[(m["time"], (m["tip_y"] - r["metrics"][0]["tip_y"]) / length) for m in r["metrics"] if m["time"] <= seconds] for _, r in results]
    low = min(y for curve in shown for _, y in curve) * 1.05
    px = lambda t: left + w * t / seconds
    py = lambda y: top + h * y / low
    for k in range(11):
        body += f'<line x1="{px(k / 2)}" x2="{px(k / 2)}" y1="{top}" y2="{top + h}" stroke="#eee"/>\n' + text(px(k / 2), top + h + 18, f"{k / 2:g} s")
    step = 0.1 if -low < 0.6 else 0.2
    for k in range(int(-low / step) + 1):
        body += f'<line x1="{left}" x2="{left + w}" y1="{py(-k * step)}" y2="{py(-k * step)}" stroke="#eee"/>\n' + text(left - 8, py(-k * step) + 5, f"{-k * step:.1f}", "end")
    for k, (label, _) in enumerate(results):
        points = " ".join(f"{px(t):.1f},{py(y):.1f}" for t, y in shown[k])
        body += f'<polyline points="{points}" fill="none" stroke="{inks[k]}" stroke-width="2"/>\n'
        body += text(125 + 238 * k, 24, label, fill=inks[k], font_weight="bold")
    body += text(left + w, top - 8, "height of the tip, lengths; above: each bar at its lowest, muscle red, fat yellow", "end", font_size=12)
    svg("figure-8", width, height, body)
    frames = len(results[0][1]["metrics"])
    rms = {}
    for a in range(4):
        for b in range(a):
            ma, mb = results[a][1]["metrics"], results[b][1]["metrics"]
            total = sum((ma[f][f"tip_{c}"] - mb[f][f"tip_{c}"]) ** 2 for f in range(frames) for c in "xyz")
            rms[f"{names[b][0]} / {names[a][0]}"] = math.sqrt(total / frames) / length
    return rms


def read_png(path):
    """Width, height and rows of a PNG with 8 bits a channel, RGB or RGBA, not interlaced; rows as RGB bytes."""
    data = open(path, "rb").read()
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
    return width, height, rows


# Seconds of the jump: stand, crouch, take-off, apex, the belly's lowest after landing, on the way up.
JUMP = (0.0, 0.85, 1.13, 1.38, 1.8, 2.1)


def strip(program, folder, name, frames, *options):
    """Stills side by side: the rows of the picture, RGB."""
    stills = []
    for frame in frames:
        path = os.path.join(OUT, f"{name}-{frame}.png")
        subprocess.run([program, "render", folder, "-o", path, "--frame", str(frame), *options, "--overwrite", "-q"],
                       check=True, stdout=subprocess.DEVNULL)
        stills.append(read_png(path))
    return [b"".join(still[2][y] for still in stills) for y in range(stills[0][1])]


def save_strips(name, strips):
    canvas = Canvas(0, 0)
    canvas.w, canvas.h, canvas.pixels = len(strips[0]) // 3, len(strips), b"".join(strips)
    with open(f"docs/figures/{name}.png", "wb") as file:
        file.write(canvas.png())
    print(f"docs/figures/{name}.png")


def figure_9(program):
    """Stills of the jump side by side; below, the same with how far the flesh is from where skinning has it."""
    folder = bake(program, "jump")
    fps = json.load(open(os.path.join(folder, "manifest.json"), encoding="utf-8"))["scene"]["fps"]
    frames = [round(time * fps) for time in JUMP]
    strips = []
    for mode in ("shaded", "lag"):
        strips += strip(program, folder, f"jump-{mode}", frames, "--mode", mode, "--lag-scale", "200", "--turn", "-10", "--size", "190x285")
    save_strips("figure-9", strips)
    metrics = read_bake(folder)["metrics"]
    return {"belly, lowest and highest, m": [f([m["belly_y"] for m in metrics]) for f in (min, max)]}


# Frames of the arm's curl: straight, on the way, and folded to 160 degrees.
CURL = (0, 60, 75, 90, 115)


def figure_10(program):
    """Stills of the curl with muscles; below, the same without; and the volume of both over the bend."""
    silent = [f"--set=muscle.{name}.gain=0" for name in ("biceps", "triceps")]
    folders = [bake(program, "arm"), bake(program, "arm", "arm-without", silent)]
    strips = []
    for name, folder in zip(("arm", "arm-without"), folders):
        strips += strip(program, folder, name, CURL, "--view", "front", "--size", "230x160")
    save_strips("figure-10", strips)
    curves = [[(m["time"], m["volume_ratio"]) for m in read_bake(folder)["metrics"]] for folder in folders]
    width, height, left, top, w, h = 960, 260, 70, 30, 860, 180
    end, low, high = curves[0][-1][0], min(v for c in curves for _, v in c), max(v for c in curves for _, v in c)
    low, high = math.floor(200 * low) / 200, math.ceil(200 * high) / 200
    px = lambda t: left + w * t / end
    py = lambda v: top + h * (high - v) / (high - low)
    body = ""
    for k in range(int(2 * end) + 1):
        body += f'<line x1="{px(k / 2)}" x2="{px(k / 2)}" y1="{top}" y2="{top + h}" stroke="#e4e4e4"/>\n' + text(px(k / 2), top + h + 18, f"{k / 2:g} s")
    for k in range(round(200 * (high - low)) + 1):
        v = low + k / 200
        body += f'<line x1="{left}" x2="{left + w}" y1="{py(v)}" y2="{py(v)}" stroke="#e4e4e4"/>\n' + text(left - 8, py(v) + 5, f"{100 * v:.1f} %", "end")
    for k, (label, ink) in enumerate((("with muscles", "#a52a2a"), ("without", "#555753"))):
        points = " ".join(f"{px(t):.1f},{py(v):.1f}" for t, v in curves[k])
        body += f'<polyline points="{points}" fill="none" stroke="{ink}" stroke-width="2"/>\n' + text(left + 80 + 130 * k, 20, label, fill=ink, font_weight="bold")
    body += text(left + w, 20, "volume of the whole arm, of that at rest", "end", font_size=12)
    svg("volume", width, height, body)
    return {"volume, mean difference": sum(abs(a / b - 1) for (_, a), (_, b) in zip(*curves)) / len(curves[0])}


def lag(program, scene, figure, more=()):
    """How far each layer is behind the skeleton; the clip's last pose is held for as long as the flesh may take to settle."""
    hold = 1.5
    metrics = read_bake(bake(program, scene, figure, ["--hold", str(hold), *more]))["metrics"]
    layers = [(name, ink) for name, ink in (("fat", "#c98a00"), ("muscle", "#a52a2a")) if f"lag_{name}" in metrics[0]]
    end, peak = metrics[-1]["time"], max(m[f"lag_{name}"] for name, _ in layers for m in metrics)
    width, height, left, top, w, h = 960, 300, 70, 30, 860, 220
    px = lambda t: left + w * t / end
    py = lambda y: top + h - h * y / (1.05 * peak)
    step = next(s for s in (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 1.0) if peak / s < 8)
    body = f'<rect x="{px(end - hold)}" y="{top}" width="{w * hold / end}" height="{h}" fill="#f4f4f4"/>\n'
    body += text(px(end - hold / 2), top + h - 8, "last pose held", font_size=12)
    for k in range(int(2 * end) + 1):
        body += f'<line x1="{px(k / 2)}" x2="{px(k / 2)}" y1="{top}" y2="{top + h}" stroke="#e4e4e4"/>\n' + text(px(k / 2), top + h + 18, f"{k / 2:g} s")
    for k in range(int(1.05 * peak / step) + 1):
        body += f'<line x1="{left}" x2="{left + w}" y1="{py(k * step)}" y2="{py(k * step)}" stroke="#e4e4e4"/>\n' + text(left - 8, py(k * step) + 5, f"{1000 * k * step:g} mm", "end")
    settled = {}
    for k, (name, ink) in enumerate(layers):
        curve = [m[f"lag_{name}"] for m in metrics]
        points = " ".join(f"{px(m['time']):.1f},{py(y):.1f}" for m, y in zip(metrics, curve))
        body += f'<polyline points="{points}" fill="none" stroke="{ink}" stroke-width="2"/>\n'
        body += text(left + 60 + 80 * k, 20, name, fill=ink, font_weight="bold")
        settled[name] = {"peak, m": max(curve), "at the end, m": curve[-1],
                         "1.5 s before the end, less the end, of the peak": (next(y for m, y in zip(metrics, curve) if m["time"] >= end - hold) - curve[-1]) / max(curve)}
    body += text(left + w, 20, "root mean square distance to where skinning alone has the layer", "end", font_size=12)
    svg(figure, width, height, body)
    return settled


def main():
    program = sys.argv[1]
    if len(sys.argv) > 3:
        print(json.dumps({"lag, character": lag(program, sys.argv[2], "lag-character", ["--clip", sys.argv[3]])}, indent=2))
        return
    print(json.dumps({"figure 6, stretch": figure_6(program), "figure 7, drop": figure_7(program),
                      "figure 8, RMS distance of tips": figure_8(program), "figure 9": figure_9(program), "figure 10": figure_10(program), "lag": lag(program, "jump", "lag")}, indent=2))


if __name__ == "__main__":
    main()
