#!/usr/bin/env python3
"""Plots the results of `fascicle bench --json`: nanoseconds per vertex and substep over vertices, one curve per device.

    python3 bench/plot.py RESULTS.json PLOT.svg [--threads N] [--integrator NAME] [--mesh NAME]

Defaults are one thread, the explicit integrator and the regular mesh; an implicit time is that of one iteration. Only
Python's standard library is used.
"""
import argparse
import json
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs"))
import drawing  # noqa: E402  (it is in docs)

INKS = ["#1b6ca8", "#c0392b", "#2e8b57", "#8e44ad", "#d68910", "#566573", "#117a65", "#a04000"]
LEFT, TOP, WIDTH, HEIGHT, RIGHT = 70, 50, 640, 360, 230


def curves_of(record, threads, integrator, mesh):
    """Points (vertices, median, least) of each device, by vertices. Peers appear only for the explicit integrator."""
    curves = {}
    for row in record["results"]:
        is_peer = row["solver"].startswith("bullet")
        if row.get("mesh", "regular") != mesh:
            continue
        if row["threads"] != threads or (row["integrator"] != integrator and not (is_peer and integrator == "explicit")):
            continue
        curves.setdefault(row["device"], []).append(
            (row["vertices"], row["ns_per_vertex_substep"] / row["passes"], row["ns_least"] / row["passes"]))
    return {device: sorted(points) for device, points in curves.items()}


def ticks(low, high, steps=(1, 2, 5)):
    """Round numbers from at most the least to at least the largest value."""
    numbers = [step * 10.0 ** power for power in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for step in steps]
    first = max(k for k, n in enumerate(numbers) if n <= low)
    last = min(k for k, n in enumerate(numbers) if n >= high)
    return numbers[first:last + 1]


def spread(places, apart):
    """Moves heights so that neighbours are at least `apart` from each other; keeps their order."""
    moved = []
    for place in sorted(places):
        moved.append(max(place, moved[-1] + apart) if moved else place)
    return dict(zip(sorted(places), moved))


def plot(record, threads, integrator, mesh):
    curves = curves_of(record, threads, integrator, mesh)
    if not curves:
        raise SystemExit(f"plot: no row has {threads} threads, the integrator {integrator} and a {mesh} mesh")
    points = [p for curve in curves.values() for p in curve]
    across = ticks(min(p[0] for p in points), max(p[0] for p in points), (1,))
    up = ticks(min(p[2] for p in points), max(p[1] for p in points))

    def along(value, marks, length):
        low, high = math.log(marks[0]), math.log(marks[-1])
        return length * (math.log(value) - low) / (high - low) if high > low else length / 2

    def x(vertices):
        return LEFT + along(vertices, across, WIDTH)

    def y(ns):
        return TOP + HEIGHT - along(ns, up, HEIGHT)

    body = ""
    for n in across:
        body += f'<line x1="{x(n):.1f}" x2="{x(n):.1f}" y1="{TOP}" y2="{TOP + HEIGHT}" stroke="{drawing.GRID}"/>\n'
        body += drawing.text(f"{x(n):.1f}", TOP + HEIGHT + 20, f"{n:,.0f}")
    for n in up:
        body += f'<line x1="{LEFT}" x2="{LEFT + WIDTH}" y1="{y(n):.1f}" y2="{y(n):.1f}" stroke="{drawing.GRID}"/>\n'
        body += drawing.text(LEFT - 8, f"{y(n) + 5:.1f}", f"{n:g}", "end")
    ends = {device: y(curve[-1][1]) for device, curve in curves.items()}
    labels = spread(ends.values(), 17.0)
    for k, (device, curve) in enumerate(curves.items()):
        ink = INKS[k % len(INKS)]
        places = " ".join(f"{x(n):.1f},{y(median):.1f}" for n, median, _ in curve)
        body += f'<polyline points="{places}" fill="none" stroke="{ink}" stroke-width="2"/>\n'
        for n, median, least in curve:
            body += f'<line x1="{x(n):.1f}" x2="{x(n):.1f}" y1="{y(median):.1f}" y2="{y(least):.1f}" stroke="{ink}" stroke-width="2"/>\n'
            body += f'<circle cx="{x(n):.1f}" cy="{y(median):.1f}" r="3.5" fill="{ink}"/>\n'
        body += drawing.text(LEFT + WIDTH + 12, f"{labels[ends[device]] + 5:.1f}", f"{device}  {curve[-1][1]:.3g}", "start", fill=ink)
    machine = record["machine"]
    what = f"{threads} thread{'' if threads == 1 else 's'}, {integrator}, {mesh} mesh"
    body += drawing.text(LEFT, 24, f"ns a vertex and {'iteration' if integrator == 'implicit' else 'substep'}, {what}: {machine['processor']}, {machine['cores']} cores", "start", font_weight="bold")
    body += drawing.text(LEFT + WIDTH, TOP + HEIGHT + 40, "vertices; points are medians, lines reach down to the least", "end", font_size=12)
    return drawing.svg(LEFT + WIDTH + RIGHT, TOP + HEIGHT + 56, body)


def main():
    parser = argparse.ArgumentParser(description="Plot the results of fascicle bench --json.")
    parser.add_argument("results")
    parser.add_argument("plot")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--integrator", choices=("explicit", "implicit"), default="explicit")
    parser.add_argument("--mesh", choices=("regular", "filled"), default="regular")
    arguments = parser.parse_args()
    with open(arguments.results, encoding="utf-8") as file:
        drawn = plot(json.load(file), arguments.threads, arguments.integrator, arguments.mesh)
    with open(arguments.plot + ".tmp", "w", encoding="utf-8") as file:
        file.write(drawn)
    os.replace(arguments.plot + ".tmp", arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
