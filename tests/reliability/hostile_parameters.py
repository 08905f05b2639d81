"""Values of scene keys, drawn by the rules of the schema and against them."""

import json
import math
import os
import random
import re
import shutil
import subprocess

from bakes import BAD_INPUT, DONE, PROGRAM, hold, must_be_found
from refusals import BAD_USAGE, NOT_FINITE, ended, hold_refusal



def values_of(rule):
    """A value that the rule of a key allows, by preference at its ends, or one that it does not."""
    if "enum" in rule:
        return random.choice([*rule["enum"], "none-of-them", 3])
    kind = rule.get("type")
    if isinstance(kind, list):
        kind = random.choice(kind)
    if kind == "array":
        least = rule.get("minItems", 0)
        return [values_of(rule["items"]) for _ in range(random.choice((least, least, least, least + 1)))]
    if kind == "boolean":
        return random.choice((True, False, True, False, 2))
    if kind in ("number", "integer"):
        low = rule.get("minimum", rule.get("exclusiveMinimum", -1e6))
        high = rule.get("maximum", 1e6)
        inside = random.uniform(low, high)
        if high > 0 and random.random() < 0.5:
            inside = min(high, max(low, 10.0 ** random.uniform(-9, math.log10(high))))
        value = random.choice((low, high, inside, inside, inside, inside, rule.get("default", inside)))
        if random.random() < 0.03:
            value = random.choice((-1.0, 0.0, 1e300, -1e300, 1e-300, math.nan, math.inf))
        return int(value) if kind == "integer" and math.isfinite(value) else value
    return random.choice(("auto", "", "none-of-them"))


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


def parameters(bakes, count):
    """Values of scene keys, allowed and not, several at once: 20 frames of a bar, every tenth on the Vulkan device too,
    where there is one. Positions stay finite, or one message names a key."""
    root = bakes[0].empty_folder()
    environment = bakes[0].environment()
    keys = keys_of_schema()
    names = [key for rules in keys.values() for key in rules] + ["fascicle: error: --set", "finite", "frames"]
    hold_refusal(BAD_INPUT, "fascicle: error: solver.substeps: is 0\n", (BAD_INPUT,), names)
    must_be_found(lambda: hold_refusal(BAD_INPUT, "fascicle: error: it is bad\n", (BAD_INPUT,), names), "no name")
    devices = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True).stdout
    vulkan = "vulkan:0" in devices
    finite = refused = burst = compared = 0
    for k in range(count):
        changes = {}
        for _ in range(random.randint(1, 5)):
            table = random.choice(list(keys))
            key = random.choice(list(keys[table]))
            # The first scene has no change: what refuses all of them is found out.
            if k > 0:
                changes[table + "." + key] = toml(values_of(keys[table][key]))
        # 20 frames, whatever its rate is: so long as the rate is a number.
        rate = changes.get("scene.fps", "60.0")
        end = 20 / float(rate) if re.fullmatch(r"[0-9.e+-]+", rate) and 1e-3 <= float(rate) <= 1e5 else 0.3
        start = changes.get("scene.start", "0.0")
        if re.fullmatch(r"[0-9.e+-]+", start) and abs(float(start)) <= 1e5:
            end += float(start)
        changes["scene.end"] = repr(end)
        changes["bar.vertices"] = "[4, 3, 3]"
        sets = [word for change in changes.items() for word in ("--set", "%s=%s" % change)]
        hashes = []
        for device in ("cpu", "vulkan:0") if vulkan and k % 10 == 9 else ("cpu",):
            folder = os.path.join(root, "out")
            status, text = ended([PROGRAM, "bake", "bar-hang-none", *sets, "--device", device, "-o", folder,
                                  "--overwrite"], environment, root)
            if status == DONE:
                with open(os.path.join(folder, "manifest.json")) as file:
                    hashes.append(json.load(file)["position_hashes"])
            elif status == NOT_FINITE:
                hold_refusal(status, text, (NOT_FINITE,))
                hashes.append(None)
            else:
                hold_refusal(status, text, (BAD_USAGE, BAD_INPUT), names)
                hold(k > 0, "a scene without a change was refused: " + text)
                break
        hold(len(hashes) < 2 or hashes[0] == hashes[1], "other bits on Vulkan: " + " ".join(sets))
        compared += len(hashes) == 2
        finite += bool(hashes) and hashes[0] is not None
        burst += bool(hashes) and hashes[0] is None
        refused += not hashes
    hold(count < 50 or (finite and refused), "%d were baked and %d refused" % (finite, refused))
    shutil.rmtree(root)
    return "%d scenes: %d stayed finite, %d refused by name, %d said that they burst; %d had the same bits on Vulkan" \
        % (count, finite, refused, burst, compared)
