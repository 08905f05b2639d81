#!/usr/bin/env python3
"""Bakes a glTF character with a portable build in a root folder that holds only the C library.

    python3 tests/house/empty_root.py PROGRAM

PROGRAM is the portable `fascicle`; `fascicle-mesher` and its libraries are in the same folder. The control: without
TetGen's library the bake must fail and name it. Needs root, or user namespaces (`unshare`).
"""
import base64
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

C_LIBRARY = ("libc.so.6", "libm.so.6")
RINGS, SIDES, LENGTH, RADIUS = 24, 12, 0.6, 0.06


def arm():
    """A two-joint tube as a .gltf document; its elbow bends by 60 degrees in half a second."""
    points, joints, weights = [], [], []
    for ring in range(RINGS + 1):
        y = LENGTH * ring / RINGS
        share = min(max(y / LENGTH * 8.0 - 3.5, 0.0), 1.0)  # weight of the lower arm; an eighth of the length blends
        for side in range(SIDES):
            angle = 2.0 * math.pi * side / SIDES
            points.append((RADIUS * math.cos(angle), y, RADIUS * math.sin(angle)))
            joints.append((0, 1, 0, 0))
            weights.append((1.0 - share, share, 0.0, 0.0))
    points += [(0.0, 0.0, 0.0), (0.0, LENGTH, 0.0)]
    joints += [(0, 1, 0, 0)] * 2
    weights += [(1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)]
    low, high, top = len(points) - 2, len(points) - 1, RINGS * SIDES
    corners = []
    for side in range(SIDES):
        beside = (side + 1) % SIDES
        for ring in range(RINGS):
            a, b, up = ring * SIDES + side, ring * SIDES + beside, SIDES
            corners += [a, a + up, b, b, a + up, b + up]
        corners += [low, side, beside, high, top + beside, top + side]

    half = math.radians(60.0) / 2.0
    inverse_binds = [1.0 if i % 5 == 0 else 0.0 for i in range(16)] * 2
    inverse_binds[16 + 13] = -LENGTH / 2.0
    blob, views, accessors = b"", [], []

    def add(component, kind, rows, form, **more):
        nonlocal blob
        data = b"".join(struct.pack(form, *row) for row in rows)
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind,
                          "count": len(rows), **more})
        blob += data + b"\0" * (-len(data) % 4)
        return len(accessors) - 1

    bounds = {"min": [min(column) for column in zip(*points)], "max": [max(column) for column in zip(*points)]}
    position = add(5126, "VEC3", points, "<3f", **bounds)
    joint = add(5121, "VEC4", joints, "<4B")
    weight = add(5126, "VEC4", weights, "<4f")
    index = add(5125, "SCALAR", [(c,) for c in corners], "<I")
    inverse = add(5126, "MAT4", [inverse_binds[:16], inverse_binds[16:]], "<16f")
    times = add(5126, "SCALAR", [(0.0,), (0.5,)], "<f", min=[0.0], max=[0.5])
    turns = add(5126, "VEC4", [(0.0, 0.0, 0.0, 1.0), (0.0, 0.0, math.sin(half), math.cos(half))], "<4f")
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [{"name": "upper", "children": [1]}, {"name": "lower", "translation": [0.0, LENGTH / 2.0, 0.0]},
                  {"name": "arm", "mesh": 0, "skin": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": position, "JOINTS_0": joint, "WEIGHTS_0": weight},
                                    "indices": index}]}],
        "skins": [{"joints": [0, 1], "inverseBindMatrices": inverse}],
        "animations": [{"name": "bend", "samplers": [{"input": times, "output": turns}],
                        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}]}],
        "buffers": [{"byteLength": len(blob),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}],
        "bufferViews": views, "accessors": accessors,
    }


def fill_root(root, program):
    """Copies the program, its neighbours and the C library into an empty root."""
    loader = subprocess.run(["readelf", "--program-headers", "--wide", program], check=True, capture_output=True,
                            text=True).stdout.split("program interpreter: ")[1].split("]")[0]
    (root / loader.lstrip("/")).parent.mkdir(parents=True)
    shutil.copy(loader, root / loader.lstrip("/"))
    (root / "lib").mkdir(exist_ok=True)
    for name in C_LIBRARY:
        found = subprocess.run(["cc", f"-print-file-name={name}"], check=True, capture_output=True, text=True)
        shutil.copy(os.path.realpath(found.stdout.strip()), root / "lib" / name)
    (root / "tmp").mkdir()
    (root / "dev").mkdir()
    (root / "proc").mkdir()
    (root / "dev" / "null").touch()  # a plain file works too, and needs no privileges
    (root / "opt").mkdir()
    folder = program.parent
    for file in (program, folder / "fascicle-mesher", *folder.glob("*.so*")):
        shutil.copy(file, root / "opt" / file.name)
    (root / "arm.gltf").write_text(json.dumps(arm()))


def bake(root, output, *more):
    """Bakes the arm inside the root; returns the completed process."""
    # The mesher finds its libraries through /proc/self/exe, so mount /proc, as on every system.
    script = 'mount --rbind /proc "$0/proc" && exec chroot "$0" "$@"'
    command = ["unshare", "--mount", *(() if os.geteuid() == 0 else ("--user", "--map-root-user")), "sh", "-c", script,
               str(root), "/opt/fascicle", "bake", "/arm.gltf", "--resolution", "1500", "--device", "cpu", "-o", output,
               *more]
    # The loader has no cache here. Cached bodies go below HOME.
    environment = {"LD_LIBRARY_PATH": "/lib", "HOME": "/tmp", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder) / "root"
        root.mkdir()
        fill_root(root, pathlib.Path(program))
        done = bake(root, "/baked")
        if done.returncode != 0:
            sys.exit(f"the bake in an empty root failed with {done.returncode}:\n{done.stderr}{done.stdout}")
        manifest = json.loads((root / "baked" / "manifest.json").read_text())
        if manifest["status"] != "complete" or manifest["frames_done"] < 10:
            sys.exit(f"the bake in an empty root is not whole: {manifest['status']}, {manifest['frames_done']} frames")
        compressed = bake(root, "/compressed", "--format", "glb", "--glb-compress", "0.001")
        if compressed.returncode == 0 or "no meshoptimizer" not in compressed.stderr:
            sys.exit(f"a portable build has no meshoptimizer and must say so: {compressed.stderr}")
        for library in (root / "opt").glob("libtet*"):
            library.unlink()
        shutil.rmtree(root / "tmp")  # holds the body cached by earlier bakes
        (root / "tmp").mkdir()
        without = bake(root, "/baked-without")
        if without.returncode == 0 or "libtet" not in without.stderr + without.stdout:
            sys.exit(f"the control: without TetGen's library the bake ended with {without.returncode}:\n"
                     f"{without.stderr}{without.stdout}")
        print(f"{manifest['frames_done']} frames in an empty root, hash {manifest['position_hashes'][-1]}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
