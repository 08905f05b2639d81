"""Runs `fascicle` and reads its results: bakes, the output of `inspect`, and stills."""
import csv
import json
import os
import struct
import subprocess
import sys

import drawing


class Program:
    """The executable, and the folder for its bakes."""

    def __init__(self, path, folder):
        self.path, self.folder = os.path.abspath(path), folder

    def run(self, *arguments):
        """Its standard output. Its messages are copied to stderr; a CalledProcessError contains them too."""
        done = subprocess.run([self.path, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        sys.stderr.write(done.stderr.decode(errors="replace"))
        done.check_returncode()
        return done.stdout.decode()

    def bake(self, scene, name=None, more=()):
        folder = os.path.join(self.folder, name or scene)
        self.run("bake", scene, "-o", folder, "--format", "pc2", "--device", "cpu", "--overwrite", "-q", *more)
        return Bake(folder)

    def inspect(self, scene, *more):
        return json.loads(self.run("inspect", scene, "--json", "-q", *more))

    def still(self, what, name, *options):
        """The rows of one picture, of a frame of a bake or of a scene at rest."""
        path = os.path.join(self.folder, name + ".png")
        os.makedirs(self.folder, exist_ok=True)
        self.run("render", what, "-o", path, "--overwrite", "-q", *options)
        return drawing.read_png(path)

    def strip(self, bake, name, frames, *options):
        """Stills of frames side by side."""
        return drawing.beside([self.still(bake.folder, f"{name}-{f}", "--frame", str(f), *options) for f in frames])


class Bake:
    def __init__(self, folder):
        self.folder = folder
        with open(os.path.join(folder, "manifest.json"), encoding="utf-8") as file:
            self.manifest = json.load(file)
        with open(os.path.join(folder, "metrics.csv"), encoding="utf-8") as file:
            self.metrics = [{key: number_or_text(value) for key, value in row.items()} for row in csv.DictReader(file)]

    def column(self, name):
        return [row[name] for row in self.metrics]

    def place(self, probe, frame):
        return tuple(self.metrics[frame][f"{probe}_{c}"] for c in "xyz")

    def surface(self):
        """Rest positions and triangles of rest.obj."""
        rest, triangles = [], []
        with open(os.path.join(self.folder, "rest.obj"), encoding="utf-8") as file:
            for line in file:
                words = line.split()
                if words[:1] == ["v"]:
                    rest.append(tuple(map(float, words[1:4])))
                elif words[:1] == ["f"]:
                    triangles.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:4]))
        return rest, triangles

    def positions(self, frame):
        """The surface of one frame, from surface.pc2; -1 is the last."""
        with open(os.path.join(self.folder, "surface.pc2"), "rb") as file:
            header = struct.unpack("<12siiffi", file.read(32))
            count, samples = header[2], header[5]
            assert samples == len(self.metrics), "metrics.csv and surface.pc2 count different frames"
            file.seek(12 * count * (frame % samples), os.SEEK_CUR)
            data = file.read(12 * count)
        return list(struct.iter_unpack("<3f", data))

    def size(self, axis):
        """The size of a bar at rest, m."""
        return self.manifest["scene"]["geometry"]["bar"]["size"][axis]

    def timing(self):
        """A bake's numbers for table 2; frames include those stepped before frame 0, if any."""
        m, lead = self.manifest, self.manifest["lead_in"]
        frames = m["frames_done"] + (0 if lead["was_kept"] else lead["preroll_frames"] + lead["settle_frames"])
        return {"vertices": m["model"]["vertices"], "tetrahedra": m["model"]["tetrahedra"], "frames": frames,
                "substeps": m["scene"]["solver"]["substeps"], "fps": m["scene"]["fps"], "milliseconds": 1e3 * m["timings"]["solver_seconds"] / frames,
                "device": m["device"]["name"], "threads": m["device"]["threads"]}


def number_or_text(value):
    try:
        return float(value)
    except ValueError:
        return value


def read_vtu(path):
    """The arrays of an ASCII file written by `fascicle inspect --model`, by name, each as a list of rows."""
    arrays, rows = {}, None
    with open(path, encoding="utf-8") as file:
        for line in file:
            if line.startswith("<DataArray"):
                rows = arrays.setdefault(line.split('Name="')[1].split('"')[0], [])
            elif line.startswith("<"):
                rows = None
            elif rows is not None:
                rows.append(tuple(map(float, line.split())))
    return arrays
