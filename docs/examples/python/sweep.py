"""Sweeps a parameter and plots what comes of it: how far a bar's tip sinks, by its stiffness.

    sweep.py OUT.svg [END]

Draws with matplotlib where that is installed, else by itself. END: seconds of motion.
"""

import sys

import numpy as np

import fascicle

ALPHAS = (0.1, 0.2, 0.4, 0.8)

BAR = """
[bar]
size = [0.4, 0.1, 0.1]
vertices = [9, 3, 3]
[layers.flesh]
alpha = 0.5
damping = 3.0
[pin.wall]
where = { below = { axis = "x", fraction = 0.0 } }
[solver]
substeps = 32
"""


def lowest(alpha, end):
    """The lowest point of each frame, m, and its time, s."""
    scene = fascicle.Scene.parse(BAR, end=end, layers={"flesh": {"alpha": alpha}})
    solver = fascicle.Solver(fascicle.Model(scene), fascicle.Device("cpu"))
    solver.start_clip()
    heights = [solver.world_positions()[:, 1].min()]
    for _ in range(scene.frame_count):
        solver.step_clip()
        heights.append(solver.world_positions()[:, 1].min())
    return np.arange(len(heights)) / scene.fps, np.array(heights)


def plot_by_matplotlib(curves, out):
    import matplotlib
    matplotlib.use("svg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots()
    for label, times, heights in curves:
        axes.plot(times, heights, label=label)
    axes.set_xlabel("s")
    axes.set_ylabel("lowest point, m")
    axes.legend()
    figure.savefig(out)


def plot_by_hand(curves, out, width=640, height=400, margin=50):
    last = max(times[-1] for _, times, _ in curves)
    low = min(heights.min() for _, _, heights in curves)
    high = max(heights.max() for _, _, heights in curves)
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif">',
             f'<rect width="{width}" height="{height}" fill="white"/>',
             f'<text x="{width / 2}" y="{height - 12}">{last:.2f} s</text>',
             f'<text x="4" y="{margin - 20}">lowest point, {low:.3f} m to {high:.3f} m</text>']
    for k, (label, times, heights) in enumerate(curves):
        x = margin + (width - 2 * margin) * times / last
        y = margin + (height - 2 * margin) * (high - heights) / (high - low)
        color = f"hsl({360 * k // len(curves)},70%,45%)"
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y))
        lines.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2"/>')
        lines.append(f'<text x="{width - 2 * margin}" y="{margin + 18 * k}" fill="{color}">{label}</text>')
    with open(out, "w", encoding="utf-8") as file:
        file.write("\n".join(lines + ["</svg>\n"]))


def main(out, end=1.0):
    curves = []
    for alpha in ALPHAS:
        times, heights = lowest(alpha, end)
        curves.append((f"alpha {alpha}", times, heights))
        print(f"alpha {alpha}: the tip sinks to {heights.min():.4f} m")
    try:
        plot_by_matplotlib(curves, out)
    except ImportError:
        plot_by_hand(curves, out)


if __name__ == "__main__":
    main(sys.argv[1], *map(float, sys.argv[2:]))
