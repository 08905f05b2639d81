"""Random values of scene keys, within the schema and outside it."""

import array
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys

from bakes import BAD_INPUT, DEVICE, DONE, PROGRAM, hold, must_be_found
from refusals import BAD_USAGE, INTERRUPTED, NOT_FINITE, controls, ended_or_stopped, hold_refusal, in_pairs


def values_of(rule, is_hostile):
    """A random value within a key's rule, often at its bounds; if hostile, perhaps outside it."""
    if "enum" in rule:
        return random.choice([*rule["enum"], *(("none-of-them", 3) if is_hostile else ())])
    kind = rule.get("type")
    if isinstance(kind, list):
        kind = random.choice(kind)
    if kind == "array":
        least = rule.get("minItems", random.randint(0, 3))
        more = 1 if is_hostile and random.random() < 0.25 else 0
        return [values_of(rule["items"], is_hostile) for _ in range(least + more)]
    if kind == "boolean":
        return random.choice((True, False, True, False, *((2,) if is_hostile else ())))
    if kind in ("number", "integer"):
        low = rule.get("minimum", rule.get("exclusiveMinimum", -1e6))
        high = rule.get("maximum", 1e6)
        inside = random.uniform(low, high)
        if high > 0 and random.random() < 0.5:
            inside = min(high, max(low, 10.0 ** random.uniform(-9, math.log10(high))))
        ends = (low, high) if is_hostile or "exclusiveMinimum" not in rule else (high,)
        value = random.choice((*ends, inside, inside, inside, inside, rule.get("default", inside)))
        if is_hostile and random.random() < 0.03:
            value = random.choice((-1.0, 0.0, 1e300, -1e300, 1e-300, math.nan, math.inf))
        if isinstance(value, str):  # the default "auto"
            return value
        return int(value) if kind == "integer" and math.isfinite(value) else value
    return random.choice(("auto", "", "none-of-them") if is_hostile else ("auto",))


def toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    text = repr(value)
    return text if isinstance(value, int) or not math.isfinite(value) or "." in text or "e" in text else text + ".0"


# Two bars pushed by a wind and a point force onto a plane, a rising ball and each other.
PUSHED = """
[scene]
[bar]
size = [0.2, 0.1, 0.1]
vertices = [4, 3, 3]
count = 2
[layers.body]
alpha = 0.5
damping = 4.0
[solver]
substeps = 10
[contact]
self = true
[force.wind]
kind = "wind"
vector = [3.0, 0.0, 0.0]
[force.blow]
kind = "point"
vector = [0.0, 0.0, 2.0]
where = { above = { axis = "y", fraction = 1.0 } }
start = 0.1
end = 0.2
[collider.floor]
shape = "plane"
center = [0.0, -0.02, 0.0]
[collider.ball]
shape = "sphere"
center = [0.1, -0.03, 0.05]
radius = 0.03
times = [0.0, 0.3]
offsets = [[0.0, 0.0, 0.0], [0.0, 0.02, 0.0]]
"""
OF_ANY = {"scene": "scene", "solver": "solver", "contact": "contact", "motion": "motion"}
OF_BAR = {**OF_ANY, "bar": "bar", "layers.body": "layer"}
OF_CHARACTER = {**OF_ANY, "layers.fat": "layer", "layers.muscle": "layer", "flesh": "flesh", "body": "body",
                "skeleton": "skeleton"}
SMALL_BAR = {"bar.vertices": "[4, 3, 3]", "solver.substeps": "10"}
SMALL_CHARACTER = {"character.resolution": "0.12"}
# (weight, scene, its tables and their names in the schema, settings that keep it small and at STEPS). A bar with each
# integrator; forces, colliders and contact; a muscle; and a generated body. PUSHED is the text of its scene.
SCENES = (
    (22, "bar-hang-none", OF_BAR, SMALL_BAR),
    (22, "rod-hang", OF_BAR, SMALL_BAR),
    (22, PUSHED, {**OF_BAR, "force.wind": "force", "force.blow": "force", "collider.floor": "collider",
                  "collider.ball": "collider"}, {}),
    (5, "arm", {**OF_CHARACTER, "muscle.biceps": "muscle"}, SMALL_CHARACTER),
    (1, "crouch", OF_CHARACTER, {**SMALL_CHARACTER, "motion.hold": "0.0"}),
)
FRAMES, STEPS = 20, 200
# Other names that a message may use when a key of a table was changed: a new body may have no place for a muscle or
# probe, the size of a bar limits its mesh, and no layer may be left that a force moves or that can touch another.
FOLLOWS = {"body": ("muscle.biceps", "probe.biceps", "probe.belly"), "skeleton": ("muscle.biceps",), "bar": ("mesh",),
           **{"layers." + name: ("contact", "layers: fibre_field", "force.blow", "force.wind")
              for name in ("body", "fat", "muscle")}}
# Keys that name files, attributes or other tables, ask for millions of vertices, or take free text.
LEFT_OUT = ("where", "alpha_attribute", "ignore", "attribute", "description", "vertices", "seed", "cuts", "resolution",
            "bones", "not_bones", "kinematic", "simulated", "rigid", "only", "parent", "child", "layer", "twist_joint",
            "contraction_channel")


def keys_of_schema(schema, tables):
    """{table: {key: rule}} of the tables of a scene."""
    found = {table: {key: rule for key, rule in schema["$defs"][name]["properties"].items()
                     if key not in LEFT_OUT or (key == "kinematic" and name == "layer")}
             for table, name in tables.items()}
    hold(sum(map(len, found.values())) > 40, "the schema has hardly any keys")
    return found


# Keys that only make a bake longer. Mostly drawn small, so that most bakes finish.
OF_LENGTH = ("motion.handles", "motion.settle", "motion.preroll", "motion.hold", "motion.loop",
             "motion.seamless_cycles", "bar.count")


def drawn_changes(keys):
    """{key: value in TOML} of one to five keys; half of the draws stay within the schema."""
    changes, is_hostile = {}, random.random() < 0.5
    for _ in range(random.randint(1, 5)):
        table = random.choice(list(keys))
        key = random.choice(list(keys[table]))
        name, value = table + "." + key, values_of(keys[table][key], is_hostile)
        if name in OF_LENGTH and isinstance(value, (int, float)) and value > 20 and random.random() < 0.93:
            value = random.randint(1, 20)
        changes[name] = toml(value)
    return changes


def with_frames(changes):
    """Sets the end time for FRAMES frames, or more if frames have few steps, at any valid frame rate."""
    number = lambda key, other, least, most: float(changes[key]) if key in changes and re.fullmatch(
        r"-?[0-9.e+-]+", changes[key]) and least <= float(changes[key]) <= most else other
    frames = max(FRAMES, math.ceil(STEPS / number("solver.substeps", 10, 1, 1000)))
    end = number("scene.start", 0.0, -1e5, 1e5) + frames / number("scene.fps", 60.0, 1e-3, 1e5)
    return {**changes, "scene.end": repr(end)}


def hold_finite(path):
    """Every position in a .pc2 file is finite."""
    with open(path, "rb") as file:
        content = file.read()
    numbers = array.array("f", content[32:])
    if sys.byteorder == "big":
        numbers.byteswap()
    hold(content.startswith(b"POINTCACHE2") and numbers, path + ": no positions")
    hold(all(map(math.isfinite, numbers)), path + ": a position is not finite")


def hold_names(text, changed):
    """The error names a changed key, its table, or a name in FOLLOWS."""
    tables = {key.rpartition(".")[0] for key in changed}
    names = {*changed, *tables, *(name for table in tables for name in FOLLOWS.get(table, ()))}
    error = "".join(line for line in text.splitlines() if line.startswith("fascicle: error: "))
    hold(any(re.search(r"(?<![\w.-])%s(?![\w-])" % re.escape(name), error) for name in names),
         "the error names none of %s: %s" % (", ".join(sorted(names)), text))


def try_values(inputs):
    """(hashes, steps, was stopped, text): the position hashes on each device, None for positions that burst. Empty if a
    key was refused, or if the bake was stopped because it was asked for far too many frames."""
    scene, changes, devices, environment, folder = inputs
    sets = [word for change in changes.items() for word in ("--set", "%s=%s" % change)]
    hashes, steps = [], 0
    for device in devices:
        out = os.path.join(folder, device.partition(":")[0])
        command = [PROGRAM, "bake", scene, *sets, "--device", device, "--threads", "1", "--format", "pc2", "-o", out]
        status, text = ended_or_stopped(command, environment, environment["TMPDIR"])
        text = " ".join(command) + "\n" + text
        if status == DONE:
            with open(os.path.join(out, "manifest.json")) as file:
                said = json.load(file)
            hashes.append(said["position_hashes"])
            steps = said["frames"] * said["scene"]["solver"]["substeps"]
            hold_finite(os.path.join(out, "surface.pc2"))
        elif status == NOT_FINITE:
            hold_refusal(status, text, (NOT_FINITE,))
            hashes.append(None)
        elif status == INTERRUPTED:
            return [], 0, True, text
        else:
            hold_refusal(status, text, (BAD_USAGE, BAD_INPUT))
            hold_names(text, changes)
            return [], 0, False, text
    hold(len(hashes) < 2 or hashes[0] == hashes[1], "different bits on Vulkan: %s %s" % (scene, " ".join(sets)))
    shutil.rmtree(folder, ignore_errors=True)
    return hashes, steps, False, ""


def controls_of_values(root):
    """Controls: a message about another key, and files with positions that are not finite."""
    text = "fascicle: error: layers.body.alpha: is 0, at the end of the start; must be above 0\n"
    hold_names(text, ("layers.body.alpha",))
    for others in (("scene.end", "scene.start", "solver.substeps"), ("layers.bod.alpha",), ("body.cage",)):
        must_be_found(lambda: hold_names(text, others), "a message about another key")
    path = os.path.join(root, "control.pc2")
    for value, is_finite in ((1.0, True), (math.nan, False), (-math.inf, False)):
        with open(path, "wb") as file:
            file.write(b"POINTCACHE2\0" + bytes(20))
            array.array("f", [0.0, 1e38, value]).tofile(file)
        if is_finite:
            hold_finite(path)
        else:
            must_be_found(lambda: hold_finite(path), "a position of %r" % value)


def parameters(bakes, count):
    """Random values go into the keys of scenes, valid and invalid, several at once: bars with either integrator, bars
    with forces, colliders and contact, an arm with muscles, and a bear. Each bakes 20 frames, or more until it has
    taken 200 solver steps. A fifth also bakes on the Vulkan device, where there is one. A bake either writes finite
    positions, with the same bits on both devices; or ends with 5 and says that positions burst; or is refused with one
    message that names a key that was changed, or one in its table that conflicts with it. A bake that takes more than
    10 s says that it is at work, and a signal ends it. Left as they are: keys that name files, places, joints or
    layers, and those that set the number of vertices (`load` has many)."""
    root = bakes[0].empty_folder()
    environment = bakes[0].environment(TMPDIR=root)
    schema = json.loads(subprocess.run([PROGRAM, "schema"], capture_output=True, text=True, check=True).stdout)
    with open(os.path.join(root, "pushed.toml"), "w") as file:
        file.write(PUSHED)
    kinds = [(share, os.path.join(root, "pushed.toml") if scene == PUSHED else scene, keys_of_schema(schema, tables),
              small) for share, scene, tables, small in SCENES]
    controls(environment, root)
    controls_of_values(root)
    devices = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True).stdout
    gpu = DEVICE if DEVICE.startswith("vulkan:") else "vulkan:0"
    vulkan = gpu in devices
    # The first scene of each kind is unchanged: it would expose a program that refuses everything.
    bare = len(kinds) if count >= 50 else 1

    def drawn():
        for k in range(count):
            _, scene, keys, small = kinds[k] if k < bare else random.choices(kinds, [kind[0] for kind in kinds])[0]
            changes = with_frames({**small, **(drawn_changes(keys) if k >= bare else {})})
            on = ("cpu", gpu) if vulkan and k % 5 == 0 else ("cpu",)
            yield scene, changes, on, environment, os.path.join(root, str(k))

    refused = burst = compared = stopped = 0
    steps = []
    for k, (hashes, of_bake, is_at_work, text) in enumerate(in_pairs(try_values, drawn())):
        hold(hashes or is_at_work or k >= bare, "an unchanged scene was refused: " + text)
        is_finite = bool(hashes) and hashes[0] is not None
        compared += len(hashes) == 2 and is_finite
        burst += bool(hashes) and not is_finite
        stopped += is_at_work
        refused += not hashes and not is_at_work
        if is_finite:
            steps.append(of_bake)
    finite = len(steps)
    hold(count < 50 or (finite and refused), "%d baked and %d refused: both must occur" % (finite, refused))
    least = max(1, count // 16) if count >= 50 else 1
    hold(not vulkan or compared >= least, "only %d of %d were compared on Vulkan" % (compared, count))
    shutil.rmtree(root)
    on_vulkan = "%d had the same bits on Vulkan" % compared if vulkan else "NOT TESTED: there is no Vulkan device"
    return "%d scenes: %d stayed finite, %d of these for %d solver steps or more (the median took %d); %d were " \
           "refused by name, %d reported that they burst, %d were long, said so and were stopped; %s" % (
               count, finite, sum(n >= STEPS for n in steps), STEPS, sorted(steps)[finite // 2], refused, burst,
               stopped, on_vulkan)
