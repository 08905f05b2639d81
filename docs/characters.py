"""Figures of characters that are not part of the project. A folder of assets holds them; without it, earlier results are
kept."""
import math
import os

import drawing
import figures

MAN, HEAVY_MAN, BUNNY = "mh_muscle.glb", "mh_fat.glb", "bunny.off"
EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "examples")


def missing(folder):
    """Returns why the folder is unusable, or an empty string."""
    names = [name for name in (MAN, HEAVY_MAN, BUNNY) if not os.path.isfile(os.path.join(folder, name))]
    return f"{folder} lacks {', '.join(names)}" if names else ""


def biceps_curl(program, assets, folder):
    """A man's curl with the five-line muscle of the example and, below, without it; and the volume of both."""
    scene = os.path.join(EXAMPLES, "curling-man.toml")
    options = [f"--set=character.file={os.path.abspath(os.path.join(assets, MAN))}", "--clip", "biceps_curl"]
    curl = program.bake(scene, "biceps-curl", options)
    silent = program.bake(scene, "biceps-curl-without", [*options, "--set=muscle.upper-arm.gain=0"])
    still = lambda bake, frame: drawing.crop(program.still(bake.folder, "curl", "--frame", str(frame), *MAN_VIEW), MAN_ARM)
    rows = [row for bake in (curl, silent) for row in drawing.beside([still(bake, frame) for frame in MAN_CURL])]
    figures.save(folder, "biceps-curl.png", drawing.png(rows))
    figures.draw_volumes([("with muscle", "#a52a2a", curl), ("without", "#555753", silent)], "volume of the whole man, of that at rest",
                         0.005, folder, "biceps-curl-volume.svg")
    moved = max(math.dist(p, q) for frame in MAN_CURL for p, q in zip(curl.positions(frame), silent.positions(frame)))
    return ({"volume, mean difference": figures.mean_difference(curl, silent), "skin moves by at most, m": moved},
            {"man, biceps_curl": curl.timing()})


# Frames of the clip (straight, and two while bending), the camera, and the left arm's rectangle in the picture.
MAN_CURL = (0, 40, 60)
MAN_VIEW = ("--view", "front", "--turn", "60", "--size", "1400x1400")
MAN_ARM = (740, 270, 1040, 560)


def measure(program, assets, folder):
    curl, timing = biceps_curl(program, assets, folder)
    lag, _ = figures.lag(program, os.path.join(assets, HEAVY_MAN), folder, "lag-character", ["--clip", "jump"])
    bunny = figures.volume_shares(program, os.path.join(EXAMPLES, "bunny.toml"), [f"--set=mesh.file={os.path.abspath(os.path.join(assets, BUNNY))}"])
    return {"curl": curl, "lag": lag, "bunny": bunny}, timing
