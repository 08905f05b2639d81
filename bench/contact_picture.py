#!/usr/bin/env python3
"""Draws docs/figures/contact-bullet.png from the bakes of `./do peers --bakes BAKES`: the bear held in its crouch, with
skinning alone, with Bullet, and with fascicle.

    python3 bench/contact_picture.py PROGRAM BAKES PICTURE.png
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs"))
import bakes  # noqa: E402
import drawing  # noqa: E402
import figures  # noqa: E402


def main(program, folder, picture):
    program = bakes.Program(program, folder)
    program.bake("crouch", "crouch-skinned", figures.SKINNING_ALONE)
    options = ("--frame", str(figures.CROUCH), "--view", "front", "--turn", "40", "--size", "900x900")
    # The bear's place in a picture of 900 by 900.
    crouched = [round(0.9 * side) for side in figures.CROUCHED]
    stills = [program.still(os.path.join(folder, f"crouch-{name}"), f"still-{name}", *options) for name in ("skinned", "bullet", "fascicle")]
    with open(picture, "wb") as file:
        file.write(drawing.png(drawing.beside([drawing.crop(rows, crouched) for rows in stills])))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
