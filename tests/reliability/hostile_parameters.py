"""Values of scene keys, drawn by the rules of the schema and against them."""

import json
import math
import os
import random
import re
import shutil
import subprocess

from bakes import BAD_INPUT, DONE, PROGRAM, hold, must_be_found
from refusals import BAD_USAGE, INTERRUPTED, NOT_FINITE, controls, ended_or_stopped, hold_refusal, in_pairs


def values_of(rule, is_hostile):
    """A value that the rule of a key allows, by preference at its ends; where hostile, perhaps one that it does not."""
    if "enum" in rule:
        return random.choice([*rule["enum"], *(("none-of-them", 3) if is_hostile else ())])
    kind = rule.get("type")
    if isinstance(kind, list):
        kind = random.choice(kind)
    if kind == "array":
        least = rule.get("minItems", 0)
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
        if isinstance(value, str):  # a default of "auto"
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


def keys_of_schema():
    """{table: {key: rule}} of those tables that hold for any bar, without what names files or other tables."""
    schema = json.loads(subprocess.run([PROGRAM, "schema"], capture_output=True, text=True, check=True).stdout)
    left_out = {"layer": ("where", "alpha_attribute"), "contact": ("ignore", "attribute"), "scene": ("description",),
                "bar": ("vertices", "count", "seed"), "motion": ("cuts",)}
    found = {}
    for table, path in (("scene", "scene"), ("bar", "bar"), ("solver", "solver"), ("layer", "layers.body"),
                        ("contact", "contact"), ("motion", "motion")):
        rules = schema["$defs"][table]["properties"]
        found[path] = {key: rule for key, rule in rules.items() if key not in left_out.get(table, ())}
    hold(sum(map(len, found.values())) > 40, "the schema has hardly any key")
    return found


# A bar of either integrator.
SCENES = ("bar-hang-none", "rod-hang")
# Keys that only make a bake longer: mostly small, so that most come to their end.
OF_LENGTH = ("motion.handles", "motion.settle", "motion.preroll", "motion.hold", "motion.loop",
             "motion.seamless_cycles")


def drawn_changes(keys):
    """{key: value in TOML} of one to five keys; every second time as the schema allows them."""
    changes, is_hostile = {}, random.random() < 0.5
    for _ in range(random.randint(1, 5)):
        table = random.choice(list(keys))
        key = random.choice(list(keys[table]))
        name, value = table + "." + key, values_of(keys[table][key], is_hostile)
        if name in OF_LENGTH and isinstance(value, (int, float)) and value > 20 and random.random() < 0.8:
            value = random.randint(1, 20)
        changes[name] = toml(value)
    return changes


def with_twenty_frames(changes):
    """Whatever the rate is: so long as that is a number."""
    rate = changes.get("scene.fps", "60.0")
    end = 20 / float(rate) if re.fullmatch(r"[0-9.e+-]+", rate) and 1e-3 <= float(rate) <= 1e5 else 0.3
    start = changes.get("scene.start", "0.0")
    if re.fullmatch(r"[0-9.e+-]+", start) and abs(float(start)) <= 1e5:
        end += float(start)
    return {**changes, "scene.end": repr(end), "bar.vertices": "[4, 3, 3]"}


def try_values(inputs):
    """The position hashes on each device; None where the positions burst, and no list where a key was refused. What
    was stopped at work, as it was asked for far too many frames, has no hashes either: (hashes, is at work, text)."""
    scene, sets, devices, names, environment, folder = inputs
    hashes = []
    for device in devices:
        out = os.path.join(folder, device.partition(":")[0])
        status, text = ended_or_stopped([PROGRAM, "bake", scene, *sets, "--device", device, "--threads", "1", "-o",
                                         out], environment, environment["TMPDIR"])
        if status == DONE:
            with open(os.path.join(out, "manifest.json")) as file:
                hashes.append(json.load(file)["position_hashes"])
        elif status == NOT_FINITE:
            hold_refusal(status, text, (NOT_FINITE,))
            hashes.append(None)
        elif status == INTERRUPTED:
            return [], True, text
        else:
            hold_refusal(status, text, (BAD_USAGE, BAD_INPUT), names)
            return [], False, text
    hold(len(hashes) < 2 or hashes[0] == hashes[1], "other bits on Vulkan: " + " ".join(sets))
    shutil.rmtree(folder, ignore_errors=True)
    return hashes, False, ""


def parameters(bakes, count):
    """Values of scene keys, allowed and not, several at once: 20 frames of a bar of either integrator, every eighth
    on the Vulkan device too, where there is one, with the same bits. Positions stay finite, or one message names a key.
    A bake that was asked for hours says that it is at work, and a signal ends it."""
    root = bakes[0].empty_folder()
    environment = bakes[0].environment(TMPDIR=root)
    keys = keys_of_schema()
    names = [key for rules in keys.values() for key in rules]
    names += ["fascicle: error: --set", "finite", "frames"]
    controls(environment, root)
    hold_refusal(BAD_INPUT, "fascicle: error: solver.substeps: is 0; must be above 0\n", (BAD_INPUT,), names)
    must_be_found(lambda: hold_refusal(BAD_INPUT, "fascicle: error: it is bad; give another\n", (BAD_INPUT,), names),
                  "no name")
    devices = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True).stdout
    vulkan = "vulkan:0" in devices

    def drawn():
        for k in range(count):
            # The first scene has no change: what refuses all of them is found out.
            changes = with_twenty_frames(drawn_changes(keys) if k > 0 else {})
            sets = [word for change in changes.items() for word in ("--set", "%s=%s" % change)]
            on = ("cpu", "vulkan:0") if vulkan and k % 8 == 5 else ("cpu",)
            yield SCENES[(k + k // 8) % 2], sets, on, names, environment, os.path.join(root, str(k))

    finite = refused = burst = compared = stopped = 0
    for k, (hashes, is_at_work, text) in enumerate(in_pairs(try_values, drawn())):
        hold(hashes or k > 0, "a scene without a change was refused: " + text)
        compared += len(hashes) == 2
        finite += bool(hashes) and hashes[0] is not None
        burst += bool(hashes) and hashes[0] is None
        stopped += is_at_work
        refused += not hashes and not is_at_work
    hold(count < 50 or (finite and refused), "%d were baked and %d refused" % (finite, refused))
    shutil.rmtree(root)
    return "%d scenes: %d stayed finite, %d refused by name, %d said that they burst, %d were long, said so and were " \
           "stopped; %d had the same bits on Vulkan" % (count, finite, refused, burst, stopped, compared)
