"""Bakes every clip of every character of a folder.

    bake_folder.py CHARACTERS OUT [END]

Clips that are baked already are left alone, and those that were interrupted go on. END cuts clips, in seconds.
"""

import json
import pathlib
import sys

import fascicle


def is_complete(folder):
    manifest = folder / "manifest.json"
    return manifest.exists() and json.loads(manifest.read_text())["status"] == "complete"


def bake_clips(file, out, end):
    for clip in fascicle.Scene(file).clip_names:
        folder = out / file.stem / clip.replace("/", "-")
        if is_complete(folder):
            print(f"{file.name}, {clip}: is there")
            continue
        result = fascicle.bake(file, folder, clip=clip, end=end, formats=["pc2"],
                               resume=folder.exists(), progress=True)
        print(f"{file.name}, {clip}: {result.frames} frames, {result.position_hash}")


def main(characters, out, end=None):
    failed = 0
    for file in sorted(pathlib.Path(characters).glob("*.glb")):
        try:
            bake_clips(file, pathlib.Path(out), end)
        except fascicle.Error as error:
            print(f"{file.name}: {error}", file=sys.stderr)
            failed += 1
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], float(sys.argv[3]) if len(sys.argv) > 3 else None))
