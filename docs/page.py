"""Writes docs/paper.md from its numbers; measures nothing."""

import textwrap

COLUMNS = 120


def wrapped(text):
    """Wraps paragraphs at COLUMNS columns; tables, headings and pictures keep their lines."""
    lines = []
    for line in text.split("\n"):
        whole = len(line) <= COLUMNS or line.startswith(("|", "#", "!"))
        lines += [line] if whole else textwrap.wrap(line, COLUMNS, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines)


def percent(share, digits=1):
    return f"{100 * share:.{digits}f} %"


def millimetres(metres, digits=1):
    return f"{1e3 * metres:.{digits}f} mm"


def two_digits(value):
    """In plain digits: 130, not 1.3e+02."""
    return f"{float(f'{value:.2g}'):g}"


def verdict(holds):
    return "It holds." if holds else "**It does not hold.**"


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def picture(words, name):
    return f"![{words}](figures/{name})\n"


def section(title, paper, ours, *parts):
    return "\n".join([f"## {title}\n", f"**The paper:** {paper}\n", f"**Here:** {ours}\n", *parts])


def shares_table(shares):
    cell = lambda values: ", ".join(percent(v) for v in values)
    return table(["bone, muscle, fat: requested", "filled"], [[cell(row["asked"]), cell(row["got"])] for row in shares])


def worst_share(shares):
    return max(abs(a - g) for row in shares for a, g in zip(row["asked"], row["got"]))


def figure_2(n, assets):
    shares = n["arm"] + (assets["bunny"] if assets else [])
    parts = [picture("An arm and a bear cut open: bone, muscle around it, fat around that", "figure-2.png"),
             "Requested shares of the volume of the arm's layers, from the inside out, and the shares that they fill:\n", shares_table(n["arm"])]
    if assets:
        parts += ["The same for the bunny (Stanford 3D Scanning Repository), which is not part of the project:\n", shares_table(assets["bunny"])]
    return section("Figure 2: layers", "a bunny in three layers, bone, muscle and fat, by distance from the bone; a user can edit the volume of each.",
                   "the built-in arm and bear, their tetrahedra cut open. Each layer fills the share of the body's volume that was requested. The tolerance is "
                   f"2 % of the body's volume; the largest difference is {percent(worst_share(shares), 2)}. {verdict(worst_share(shares) <= 0.02)}", *parts)


def figure_3(n):
    bone, skin = n["bone"], n["skin"]
    most = ("almost all of them by less than 0.01; a few by more" if max(bone["percentile 95"], skin["percentile 95"]) < 0.01
            else f"95th percentile: {bone['percentile 95']:.2f} and {skin['percentile 95']:.2f}")
    return section("Figure 3: fibres", "the field is interpolated between constraints that are parallel to the bone inside and tangent to the surface outside.",
                   "the same for the arm and the bear, cut open; lines along x are red, along y green, along z blue. In the arm, from shoulder to hand, fibres in the "
                   f"bone layer deviate from the bone by {bone['mean']:.2f} degrees in the mean, and fibres at the skin from its tangent plane by {skin['mean']:.2f} degrees "
                   f"({most}).",
                   picture("Fibres run along the bones inside and along the skin outside", "figure-3.png"))


def figure_6(n):
    s = n["stretch"]
    return section("Figure 6: a hanging bar", "it stretches when its fibres are orthogonal to gravity (b), and not when they are parallel (c), compared with no fibres (a).",
                   f"with beta 1 it stretches by {percent(s['across'])} across, {percent(s['none'])} without fibres and {percent(s['along'])} along. "
                   + verdict(s["across"] > s["none"] > s["along"]),
                   picture(f"Stretch: none {percent(s['none'], 0)}, across {percent(s['across'], 0)}, along {percent(s['along'], 0)}", "figure-6.svg"))


def figure_7(n):
    drops = [n["drop"][beta] for beta in ("0", "0.6", "0.75", "1")]
    return section("Figure 7: fibres orthogonal to the floor", "four bars with beta 0, 0.6, 0.75 and 1 hang lower and lower: the fibres act like bellows.",
                   f"their tips drop by {', '.join(f'{d:.3f}' for d in drops)} lengths. " + verdict(drops == sorted(drops) and len(set(drops)) == 4),
                   picture("The drop of the tip rises with beta", "figure-7.svg"))


LABELS = {"iwamoto": "Iwamoto et al.", "i": "our method (i)", "ii": "our method (ii)", "iii": "our method (iii)"}
# As printed: alpha_M, beta_M, alpha_F, beta_F.
TABLE_1 = {"iwamoto": (1.0, 0.0, 0.3, 0.0), "i": (1.0, 1.0, 0.3, 0.3), "ii": (1.0, 1.0, 0.3, 0.3), "iii": (1.0, 1.0, 0.3, 1.0)}


def table_1(n):
    keys = ("alpha_M", "beta_M", "alpha_F", "beta_F")
    vector = lambda v: "(" + ", ".join(f"{c:g}" for c in v) + ")"
    rows, same = [], True
    for name, printed in TABLE_1.items():
        ours = tuple(n["table 1"][name][key] for key in keys)
        same = same and ours == printed
        fibres = "none" if name == "iwamoto" else f"{vector(n['muscle fibre'][name])}, {vector(n['fat fibre'][name])}"
        rows.append([LABELS[name], f"`bar-layers-{name}`", *(f"{p:g} / {o:g}" for p, o in zip(printed, ours)), fibres])
    return section("Table 1: the parameters of figure 8", "stiffness and fibre weight of muscle and fat in the four bars. It does not state the fibre directions, and (i) and (ii) have the same row.",
                   "paper / ours, from the manifests of the bakes, and our fibre directions of muscle and fat. " + verdict(same),
                   table(["model", "scene", *(f"{k}" for k in keys), "fibres"], rows))


def figure_8(n):
    rows = [[pair.replace("iwamoto", "Iwamoto"), f"{d:.3f}"] for pair, d in n["distance of tips"].items()]
    swings = [[LABELS[name], f"{-n['lowest'][name]:.2f}", f"{s['tip']:.3f}", f"{s['middle']:.3f}"] for name, s in n["swing"].items()]
    return section("Figure 8: bars of muscle and fat", "with stiffness alone the fat jiggles; with fibres the bar bends more smoothly, and (i), (ii) and (iii) are three different motions.",
                   "the bars are held at the wall and released, with little damping. The first table gives the RMS distance between the tips of any two bars over ten seconds, in "
                   "lengths of the bar. The claim is that the motions differ. " + verdict(min(n["distance of tips"].values()) > 0.02) + " (A distance above 0.02 is visible in a picture.)",
                   picture("Four bars of muscle and fat at their lowest, and the heights of their tips over time", "figure-8.svg"),
                   table(["bars", "distance of tips"], rows), table(["bar", "tip at its lowest", "swing of the tip, rms", "swing where fat begins"], swings))


def figure_9(n, lag):
    p = n["parameters"]
    fat, muscle = n["lag"]["fat"], n["lag"]["muscle"]
    still = lag["fat"]["change in the last half second, m"]
    return section("Figure 9: a jump", "with alpha_M 1, beta_M 1, alpha_F 0.3, beta_F 0 the fat lags behind the skeleton when the character jumps.",
                   f"the built-in bear with alpha_M {p['muscle']['alpha']:g}, beta_M {p['muscle']['beta']:g}, alpha_F {p['fat']['alpha']:g}, beta_F {p['fat']['beta']:g}: stand, crouch, "
                   "take-off, apex, landing and rising again. The top row shows flesh, the middle row skinning alone, the bottom row the distance between them (yellow: 200 mm). The RMS lag "
                   f"of the layer is at most {millimetres(fat['peak'], 0)} for fat and {millimetres(muscle['peak'], 0)} for muscle. With the last pose held for 1.5 s, the fat settles "
                   f"{millimetres(lag['fat']['at the end, m'])} from where skinning puts it; in the last half second this distance changes by {millimetres(still, 2)}. "
                   + verdict(fat["peak"] > muscle["peak"] and still < 0.02 * fat["peak"]),
                   picture("A bear jumps: with flesh, by skinning alone, and the distance between them", "figure-9.png"),
                   picture("The fat's lag peaks at take-off and at landing and settles", "lag.svg"))


def crouch(n):
    litres = lambda volume: f"{1e3 * volume:.3g} l"
    return section("Beyond the paper: flesh that meets flesh", "it has no contact: flesh passes through flesh.",
                   "the bear is held in its deepest crouch. With skinning alone, "
                   f"{litres(n['by skinning alone, m3'])} of its flesh lie inside other flesh, {millimetres(n['deepest by skinning alone, m'], 0)} deep. With contact, "
                   f"{litres(n['overlap, largest, m3'])} remain in the worst frame, {millimetres(n['deepest, m'], 0)} deep. "
                   + verdict(n["overlap, largest, m3"] < 0.2 * n["by skinning alone, m3"]),
                   picture("A bear's belly stands in its thighs without contact, and lies on them with it", "crouch.png"))


PAPERS_VOLUME = 0.00291


def figure_10(n, assets):
    d = n["volume, mean difference"]
    parts = [picture("An arm curls in five stills; above with muscles, below without", "figure-10.png"),
             picture("The volume of the whole arm over the curl, with muscles and without", "volume.svg"),
             "`fascicle bake arm -o out/figure-10` bakes it.\n"]
    if assets:
        parts += ["A man with a muscle that takes five lines of scene file ([examples/curling-man.toml](examples/curling-man.toml)), above, and without it, below. Model: `mh_muscle.glb`, built from the "
                  "MakeHuman base mesh, CC0; it is not part of the project. Frames 0, 40 and 60. The muscle moves the skin by up to "
                  f"{millimetres(assets['curl']['skin moves by at most, m'])} and changes the whole man's volume over the curl by {percent(assets['curl']['volume, mean difference'], 3)} in the mean.\n",
                  picture("A man's left arm curls; above with a muscle, below without (model CC0, MakeHuman)", "biceps-curl.png"),
                  picture("The volume of the whole man over the curl, with the muscle and without", "biceps-curl-volume.svg")]
    return section("Figure 10: biceps", "an arm bends with the constraint at beta 0 (a, b) and 1 (c, d). At beta 1 the biceps bulges, and the volume over the bend differs by 0.291 % in the mean.",
                   f"the built-in arm, beta {n['beta']:g}, to 160 degrees and back. The biceps stands up to {millimetres(n['biceps, rise, m'])} higher than without muscles. Averaged over the clip's frames, the whole "
                   f"arm's volume differs by {percent(d['beta 0'], 3)} from that at beta 0, which is the paper's comparison. {verdict(d['beta 0'] <= PAPERS_VOLUME)} It differs by "
                   f"{percent(d['without muscles'], 3)} from that of the same arm at beta 1 with inactive muscles, which the pictures show" + ("." if d["without muscles"] <= PAPERS_VOLUME else ", which is more than the paper's."), *parts)


def table_2(timings):
    kinds = {"6": "bar (gravity)", "7": "bar (beta)", "8": "bar (multi-layer)", "9": "character, jump", "10": "arm, biceps", "assets": "man, biceps curl (implicit)"}
    rows, devices = [], set()
    for key, kind in kinds.items():
        for t in list(timings.get(key, {}).values())[:1]:
            runs = timings[key].values()
            least = min(r["milliseconds"] for r in runs)
            devices.add(f"{t['device']}, {t['threads']} threads")
            rows.append([kind, f"{t['vertices']:,}", f"{t['tetrahedra']:,}", f"{t['fps']:g}", t["substeps"], two_digits(least)])
    return section("Table 2: sizes and timings", "models and run times on an Intel i7-4910MQ at 2.90 GHz. Our copy of the text lacks the table's numbers, so they are not repeated here.",
                   f"solver time per frame in milliseconds, the minimum over the bakes of one model, on the CPU ({'; '.join(sorted(devices))}), from the manifests of these bakes. They hold for that machine on that day, possibly under other load. They are the only numbers "
                   "on this page that change from run to run.",
                   table(["model", "vertices", "tetrahedra", "frames/s", "substeps", "ms a frame"], rows))


def text(record):
    n, assets = record["numbers"], record["assets"]
    timings = {**record["timings"], "assets": record["assets timings"]}
    parts = ["# The paper's figures and tables, and ours\n",
             'Kaneda et al., "Fiber-dependent Approach for Fast Dynamic Character Animation", CASA 2017. `./do paper` bakes, measures and draws everything here and writes this page; do not edit it. '
             "The scenes are our own, so the comparison is with the paper's claims, not with its pixels.\n",
             figure_2(n["2"], assets), figure_3(n["3"]), figure_6(n["6"]), figure_7(n["7"]), figure_8(n["8"]), table_1(n["8"]), figure_9(n["9"], n["lag"]),
             figure_10(n["10"], assets), crouch(n["crouch"]), table_2(timings)]
    return wrapped("\n".join(parts))
