"""The paper's figures from our own scenes: each function bakes, measures, and draws into a folder; if that is None, it
only measures. A scene gives the same result on every machine, so the numbers are reproducible; timings are separate."""
import math
import os

import bakes
import drawing
from drawing import Canvas, Plot, banded, beside, crop, draw, image, text

MUSCLE, FAT, SINGLE = (0.74, 0.24, 0.22), (0.93, 0.76, 0.42), (0.45, 0.58, 0.78)


def save(folder, name, content):
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, name)
    with open(path, "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())
    print(name)


def sunk(bake):
    """How far a bar's tip has dropped at the end, in lengths of the bar."""
    length = max(bake.size(a) for a in range(3))
    return (bake.place("tip", 0)[1] - bake.place("tip", -1)[1]) / length


# Requested shares of the volume: of bone, and of bone and muscle together.
SHARES = ((0.1, 0.5), (0.2, 0.4), (0.3, 0.8))


def volume_shares(program, scene, more=()):
    """Requested and actual shares of the body, from the inside, for layers given by volume_share."""
    table = []
    for bone, muscle in SHARES:
        where = lambda layer, share: f"--set=layers.{layer}.where={{volume_share={{maximum={share}}}}}"
        layers = program.inspect(scene, where("bone", bone), where("muscle", muscle), *more)["layers"]
        got = {layer["name"]: layer["volume_share"] for layer in layers}
        table.append({"asked": [bone, round(muscle - bone, 9), round(1 - muscle, 9)], "got": [got[name] for name in ("bone", "muscle", "fat")]})
    return table


def figure_2(program, folder=None):
    """Three layers: the arm and the bear, with their tetrahedra cut open."""
    if folder:
        options = ("--mode", "layers", "--view", "front", "--clip", "z=50%")
        save(folder, "figure-2.png", drawing.png(beside([program.still("arm", "layers-arm", *options, "--size", "560x340"),
                                                        program.still("jump", "layers-jump", *options, "--size", "300x340")])))
    # The hand follows the skeleton whatever its layers, unless it is freed; shares count only what is free.
    return {"arm": volume_shares(program, "arm", ['--set=skeleton.simulated=["hand"]'])}, {}


# The field through the whole body (the scenes have it only in muscle), and the bind pose.
WHOLE_FIELD = ["--set=layers.bone.fibre_field=true", "--set=layers.fat.fibre_field=true"]
AT_REST = ["--end", "0.02", "--preroll", "0s"]


def fibre_angles(model):
    """Angles in the arm, degrees: of the bone layer's fibres to the bones (along x), of fibres at the skin to the skin."""
    place, fibre = model["position"], model["fibre"]
    faces = {}
    for a, b, c, d in ([int(v) for v in t] for t in model["connectivity"]):
        for face in ((b, c, d), (a, d, c), (a, b, d), (a, c, b)):
            key = tuple(sorted(face))
            faces[key] = None if key in faces else face
    normals = [(0.0, 0.0, 0.0)] * len(place)
    for face in filter(None, faces.values()):
        a, b, c = (place[v] for v in face)
        n = drawing.cross(drawing.sub(b, a), drawing.sub(c, a))
        for v in face:
            normals[v] = tuple(p + q for p, q in zip(normals[v], n))
    degrees = lambda cosine: math.degrees(math.acos(min(1.0, abs(cosine))))
    is_along = lambda i: 0.0 < place[i][0] < 0.56  # between shoulder and hand: beyond, bones end and skin closes over them
    bone = [degrees(fibre[i][0]) for i in range(len(place)) if model["layer"][i][0] == 2 and is_along(i)]
    skin = [90.0 - degrees(drawing.dot(fibre[i], drawing.unit(n))) for i, n in enumerate(normals) if any(n) and is_along(i)]
    return {"bone": mean_and_most(bone), "skin": mean_and_most(skin)}


def mean_and_most(values):
    """Mean and 95th percentile."""
    return {"mean": sum(values) / len(values), "percentile 95": sorted(values)[int(0.95 * len(values))], "count": len(values)}


def figure_3(program, folder=None):
    """The fibre field of the arm, cut open, and of the bear."""
    os.makedirs(program.folder, exist_ok=True)
    path = os.path.join(program.folder, "fibres.vtu")
    program.inspect("arm", "--model", path, *WHOLE_FIELD)
    arrays = bakes.read_vtu(path)
    # The tetrahedra have an array "layer" too, before that of the vertices.
    arrays["layer"] = arrays["layer"][-len(arrays["position"]):]
    if folder:
        arm, bear = (program.bake(scene, f"fibres-{scene}", [*WHOLE_FIELD, *AT_REST]).folder for scene in ("arm", "jump"))
        options = ("--mode", "fibres", "--view", "front", "--clip", "z=50%", "--frame", "0")
        save(folder, "figure-3.png", drawing.png(beside([crop(program.still(arm, "fibres-arm", *options, "--size", "800x640"), (0, 100, 800, 500)),
                                                        program.still(bear, "fibres-jump", *options, "--size", "320x400")])))
    return fibre_angles(arrays), {}


def figure_6(program, folder=None):
    """A hanging bar without fibres, with fibres across gravity and along it."""
    labels = {"none": "no fibre", "across": "fibres across gravity", "along": "fibres along gravity"}
    baked = {name: program.bake(f"bar-hang-{name}") for name in labels}
    stretch = {name: sunk(bake) for name, bake in baked.items()}
    if folder:
        length = baked["none"].size(1)
        width, height, scale = 640, 470, 240 / length
        canvas, body = Canvas(width, height), ""
        for k, (name, label) in enumerate(labels.items()):
            rest, triangles = baked[name].surface()
            points = [(p[0], p[1] - length, p[2]) for p in baked[name].positions(-1)]
            draw(canvas, points, triangles, banded(rest, SINGLE, 1, length / 10), scale, (110 + 200 * k, 60))
            body += text(125 + 200 * k, 24, label)
            body += text(125 + 200 * k, 42, f"stretch {100 * stretch[name]:.1f} %", font_weight="bold")
        save(folder, "figure-6.svg", drawing.svg(width, height, image(canvas, 0, 0) + body))
    return {"stretch": stretch}, {name: bake.timing() for name, bake in baked.items()}


def figure_7(program, folder=None):
    """Bars held at one end, with upright fibres of four weights."""
    baked = {beta: program.bake(f"bar-beta-{beta}") for beta in ("0", "0.6", "0.75", "1")}
    drops = {beta: sunk(bake) for beta, bake in baked.items()}
    if folder:
        length = baked["0"].size(0)
        width, height, scale = 900, 330, 185 / length
        canvas, body = Canvas(width, height), ""
        for k, (beta, bake) in enumerate(baked.items()):
            rest, triangles = bake.surface()
            draw(canvas, bake.positions(-1), triangles, banded(rest, SINGLE, 0, length / 10), scale, (52 + 222 * k, 130))
            body += text(115 + 222 * k, 24, f"beta {beta}")
            body += text(115 + 222 * k, 42, f"tip drops {drops[beta]:.2f} lengths", font_weight="bold")
        save(folder, "figure-7.svg", drawing.svg(width, height, image(canvas, 0, 0) + body))
    return {"drop": drops}, {f"beta {beta}": bake.timing() for beta, bake in baked.items()}


# Figure 8's bars by their row of table 1, with the colour of their curves.
BARS = {"iwamoto": ("Iwamoto et al.: beta 0, 0", "#888888"), "i": ("(i): beta 1, 0.3", "#3465a4"),
        "ii": ("(ii): other muscle fibres", "#4e9a06"), "iii": ("(iii): beta 1, 1", "#cc0000")}


def swing(bake, probe):
    """Root mean square distance of a probe from its mean place, m."""
    places = [bake.place(probe, f) for f in range(len(bake.metrics))]
    mean = [sum(p[a] for p in places) / len(places) for a in range(3)]
    return math.sqrt(sum((p[a] - mean[a]) ** 2 for p in places for a in range(3)) / len(places))


def layers_of(bake):
    return {layer["name"]: layer for layer in bake.manifest["scene"]["layers"]}


def figure_8(program, folder=None):
    """Bars of muscle, at the wall, and fat, released; table 1."""
    baked = {name: program.bake(f"bar-layers-{name}") for name in BARS}
    length = baked["i"].size(0)
    if folder:
        draw_figure_8(baked, length, folder)
    names, distance = list(BARS), {}
    for a, one in enumerate(names):
        for other in names[:a]:
            total = sum((p - q) ** 2 for f in range(len(baked[one].metrics))
                        for p, q in zip(baked[one].place("tip", f), baked[other].place("tip", f)))
            distance[f"{other} and {one}"] = math.sqrt(total / len(baked[one].metrics)) / length
    table = {name: {key + "_" + layer[0].upper(): layers_of(bake)[layer][key] for layer in ("muscle", "fat") for key in ("alpha", "beta")}
             for name, bake in baked.items()}
    return ({"distance of tips": distance, "table 1": table,
             "muscle fibre": {name: layers_of(bake)["muscle"]["fibre"] for name, bake in baked.items()},
             "fat fibre": {name: layers_of(bake)["fat"]["fibre"] for name, bake in baked.items()},
             "lowest": {name: (min(bake.column("tip_y")) - bake.place("tip", 0)[1]) / length for name, bake in baked.items()},
             "swing": {name: {probe: swing(bake, probe) / length for probe in ("tip", "middle")} for name, bake in baked.items()}},
            {name: bake.timing() for name, bake in baked.items()})


def draw_figure_8(baked, length, folder):
    width, height, scale = 960, 560, 180 / length
    canvas, body, curves = Canvas(width, 300), "", {}
    for k, (name, (label, ink)) in enumerate(BARS.items()):
        bake = baked[name]
        rest, triangles = bake.surface()
        tip = bake.column("tip_y")
        color = lambda t: MUSCLE if sum(rest[i][0] for i in t) / 3 < length / 2 else FAT
        draw(canvas, bake.positions(tip.index(min(tip))), triangles, color, scale, (64 + 238 * k, 110))
        curves[name] = [(time, (y - tip[0]) / length) for time, y in zip(bake.column("time"), tip) if time <= 5.0]
        body += text(125 + 238 * k, 24, label, fill=ink, font_weight="bold")
    low = 1.05 * min(y for curve in curves.values() for _, y in curve)
    plot = Plot((60, 320, 860, 200), 5.0, low, 0.0)
    step = 0.1 if -low < 0.6 else 0.2
    plot.grid([-k * step for k in range(int(-low / step) + 1)], lambda v: f"{v:.1f}")
    for name, (_, ink) in BARS.items():
        plot.curve(curves[name], ink)
    plot.title("height of the tip, lengths; above: each bar at its lowest, muscle red, fat yellow")
    save(folder, "figure-8.svg", drawing.svg(width, height, image(canvas, 0, 0) + body + plot.body))


# Seconds of the jump: stand, crouch, take-off, apex, the belly's lowest after landing, on the way up.
JUMP = (0.0, 0.85, 1.13, 1.38, 1.8, 2.1)
# The whole body follows the skeleton.
SKINNING_ALONE = ["--set=layers.bone.where={bone_distance={maximum=10}}"]


def figure_9(program, folder=None):
    """Stills of the bear's jump; below, skinning alone; below that, the distance between the two."""
    jump = program.bake("jump")
    if folder:
        frames = [round(time * jump.manifest["scene"]["fps"]) for time in JUMP]
        alone = program.bake("jump", "jump-skinned", SKINNING_ALONE)
        options = ("--turn", "-10", "--size", "190x285")
        save(folder, "figure-9.png", drawing.png(
            program.strip(jump, "jump", frames, *options) + program.strip(alone, "jump-skinned", frames, *options) +
            program.strip(jump, "jump-lag", frames, "--mode", "lag", "--lag-scale", "200", *options)))
    belly, layers = jump.column("belly_y"), layers_of(jump)
    return ({"belly, lowest and highest, m": [min(belly), max(belly)],
             "lag": {name: {"peak": max(jump.column(f"lag_{name}")), "last": jump.column(f"lag_{name}")[-1]} for name in ("fat", "muscle")},
             "parameters": {name: {key: layers[name][key] for key in ("alpha", "beta")} for name in ("muscle", "fat")}},
            {"jump": jump.timing()})


# A frame in which the bear is held in its deepest crouch.
CROUCH = 120
# Its rectangle in a picture of 1000 by 1000.
CROUCHED = (250, 380, 730, 960)


def crouch(program, folder=None):
    """The bear in its crouch without contact, and with it."""
    bakes = {"without": program.bake("crouch", "crouch-without", ["--set=contact.self=false"]), "with": program.bake("crouch")}
    if folder:
        options = ("--frame", str(CROUCH), "--view", "front", "--turn", "40", "--size", "1000x1000")
        save(folder, "crouch.png", drawing.png(drawing.beside(
            [drawing.crop(program.still(bake.folder, f"crouch-{name}", *options), CROUCHED) for name, bake in bakes.items()])))
    flesh = bakes["with"]
    inside = lambda column, by: by(flesh.column(column))
    return ({"overlap, largest, m3": inside("contact_volume", max), "by skinning alone, m3": inside("contact_volume_skinned", max),
             "deepest, m": inside("contact_deepest", max), "deepest by skinning alone, m": inside("contact_deepest_skinned", max)},
            {"crouch": flesh.timing()})


def volumes(bake):
    return list(zip(bake.column("time"), bake.column("volume_ratio")))


def mean_difference(one, other):
    """The mean difference of two bakes' volumes over their frames."""
    pairs = list(zip(one.column("volume"), other.column("volume")))
    return sum(abs(a / b - 1) for a, b in pairs) / len(pairs)


def draw_volumes(curves, title, step, folder, name):
    """`curves`: label, colour and bake; a grid line for every `step` of the volume at rest."""
    curves = [(label, ink, volumes(bake)) for label, ink, bake in curves]
    values = [v for _, _, curve in curves for _, v in curve]
    low, high = math.floor(min(values) / step) * step, math.ceil(max(values) / step) * step
    plot = Plot((70, 30, 860, 180), curves[0][2][-1][0], low, high)
    plot.grid([low + k * step for k in range(round((high - low) / step) + 1)], lambda v: f"{100 * v:.1f} %")
    for k, (label, ink, curve) in enumerate(curves):
        plot.curve(curve, ink)
        plot.label(150 + 130 * k, label, ink)
    plot.title(title)
    save(folder, name, drawing.svg(960, 260, plot.body))


# Frames of the arm's curl: straight, bending, and folded to 160 degrees.
CURL = (0, 60, 75, 90, 115)


def figure_10(program, folder=None):
    """Stills of the curl with muscles and, below, without; and the volume of both over the bend."""
    arm = program.bake("arm")
    silent = program.bake("arm", "arm-without", [f"--set=muscle.{name}.gain=0" for name in ("biceps", "triceps")])
    unfibred = program.bake("arm", "arm-beta-0", ["--set=layers.muscle.beta=0"])
    if folder:
        save(folder, "figure-10.png", drawing.png([row for name, bake in (("arm", arm), ("arm-without", silent))
                                                  for row in program.strip(bake, name, CURL, "--view", "front", "--size", "230x160")]))
        draw_volumes([("with muscles", "#a52a2a", arm), ("without", "#555753", silent)],
                     "volume of the whole arm, of that at rest", 0.005, folder, "volume.svg")
    return ({"volume, mean difference": {"without muscles": mean_difference(arm, silent), "beta 0": mean_difference(arm, unfibred)},
             "biceps, rise, m": max(a - b for a, b in zip(arm.column("biceps_y"), silent.column("biceps_y"))),
             "beta": layers_of(arm)["muscle"]["beta"]}, {"arm": arm.timing()})


def lag(program, scene, folder=None, figure="lag", more=()):
    """How far each layer lags behind the skeleton; the clip's last pose is held until the flesh can settle."""
    hold = 1.5
    bake = program.bake(scene, figure, ["--hold", str(hold), *more])
    end = bake.metrics[-1]["time"]
    inks = {name: ink for name, ink in (("fat", "#c98a00"), ("muscle", "#a52a2a")) if f"lag_{name}" in bake.metrics[0]}
    curves = {name: list(zip(bake.column("time"), bake.column(f"lag_{name}"))) for name in inks}
    peaks = {name: max(y for _, y in curve) for name, curve in curves.items()}
    if folder:
        peak = max(peaks.values())
        plot = Plot((70, 30, 860, 220), end, 0.0, 1.05 * peak)
        plot.shade(end - hold, "last pose held")
        step = next(s for s in (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 1.0) if peak / s < 8)
        plot.grid([k * step for k in range(int(1.05 * peak / step) + 1)], lambda v: f"{1000 * v:g} mm")
        for k, (name, ink) in enumerate(inks.items()):
            plot.curve(curves[name], ink)
            plot.label(130 + 80 * k, name, ink)
        plot.title("root mean square distance to where skinning alone has the layer")
        save(folder, f"{figure}.svg", drawing.svg(960, 300, plot.body))
    return ({name: {"peak, m": peaks[name], "as the clip ends, m": next(y for t, y in curve if t >= end - hold), "at the end, m": curve[-1][1],
                    "change in the last half second, m": max(y for t, y in curve if t >= end - 0.5) - min(y for t, y in curve if t >= end - 0.5)}
             for name, curve in curves.items()}, {scene: bake.timing()})
