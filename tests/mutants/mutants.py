"""Mutation testing: plants small faults in the sources, one at a time, and checks that the tests find them.

mutants.py [ROOM...] [--count N | --again] [--write] [--in-place]: copies the tree into build/mutants and builds it
there. Plants a random fault, then builds and runs the tests of its room until one fails. Before that, the tests must
pass on the unchanged sources, or every fault would seem to be found. Prints the surviving faults as a table, or writes
it into docs/tests.md; living.txt lists those that change no result, and why. --again plants only those that survived
when the room was last written, after tests were added. --in-place plants in this tree and builds in its build/release,
for a clone made for this purpose. FASCICLE_SEED repeats a run; the page keeps what its first run found."""

import argparse
import glob
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "tested"))
import page  # noqa: E402: it is in a sibling folder

SOURCE = os.path.dirname(os.path.dirname(HERE))
SHARED = "/dev/shm"
WORK = os.path.join(SOURCE, "build", "mutants")
TREE, BUILD = os.path.join(WORK, "tree"), os.path.join(WORK, "build")

HASHES = ("test_exactness",
          "--gtest_filter=All/ExpectedHashes.*bar*:All/ExpectedHashes.*arm*:All/ExpectedHashes.*drop*")
# The slowest tests of test_build; they run last.
SLOW = ":".join(("Caps.*", "Assets.*", "Cage.*", "Jaws.*", "Tetrahedralize.*", "Legs.*", "LowestMode.*", "OnlyWarning.*",
                 "RigidParts.*", "Muscles.*"))
BUILD_TESTS = (("test_build", "--gtest_filter=-" + SLOW), ("test_build", "--gtest_filter=" + SLOW))
# {room: (sources, tests that cover them, fastest first)}
ROOMS = {
    "kernel": (("shaders/kernel/*.inc",), (("test_cpu_reference",), HASHES)),
    "solver": (("cpu_reference/solver/*.cpp", "cpu_reference/solver/*.inc"), (("test_cpu_reference",), HASHES)),
    "weights": (tuple("host/build/%s.cpp" % name for name in (
        "fibre", "fibre_field", "layers", "mass", "one_ring", "region_stiffness", "stiffness", "weights")),
        (*BUILD_TESTS, HASHES)),
    "build": (("host/build/*.cpp",), (*BUILD_TESTS, HASHES, ("test_pipeline",))),
    "cache": (("host/build/cache.cpp", "host/build/filled_body.cpp", "host/bake/kept_start.cpp",
               "host/pipeline/kept_model.cpp"), (("test_bake",), BUILD_TESTS[0], ("test_pipeline",), BUILD_TESTS[1])),
    "resume": (("host/bake/checkpoint*.cpp", "host/bake/run_begin.cpp", "host/bake/manifest.cpp",
                "host/bake/frame_writer.cpp", "host/bake/cache_sink.cpp", "host/bake/read_frame_cache.cpp",
                "host/bake/folder.cpp", "host/bake/verify.cpp"),
               (("test_bake",), ("test_fuzz",), ("test_cli", "--gtest_filter=Bake.*:DamagedBakes.*:Batch.*:LinkedOutputs.*"))),
}
# (pattern in a line, replacement).
SWAPS = ((r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > "), (r" == ", " != "), (r" != ", " == "),
         (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "), (r" && ", " || "), (r" \|\| ", " && "),
         (r"\btrue\b", "false"), (r"\bfalse\b", "true"), (r"std::min\b", "std::max"), (r"std::max\b", "std::min"),
         (r"\+\+", "--"), (r" \+= ", " -= "), (r" -= ", " += "), (r"\bcontinue;", ";"), (r"\bbreak;", ";"),
         (r"\b0\b(?!\.)", "1"), (r"\b1\b(?!\.)", "2"), (r"\b0\.5\b", "0.25"), (r"\b2\.0\b", "3.0"), (r"\(!", "("))
# The kernels compare floating-point numbers, which are hardly ever equal: there a comparison is turned round.
BOUNDS = {r" < ": " > ", r" <= ": " >= ", r" > ": " < ", r" >= ": " <= "}
# A statement that can be left out: an assignment, or a call for its side effects.
STATEMENT = re.compile(r"^\s+(?!return|throw|const|auto|using)(?:[\w.:\[\]>-]+ [-+*/|&]?= .*|[\w.:>-]+\([^{}]*\));$")
# Programs that a test starts.
STARTED = {"test_cli": ("fascicle", "fascicle-mesher"), "test_pipeline": ("fascicle-mesher",)}
LEAST = 0.9  # share that must be found of the faults that change a result
UNKNOWN = "not looked at"
SHARDS = os.cpu_count()
# A program whose tests take longer than this, in times of its run on the unchanged sources, is in an endless loop or
# waits for itself; and the least such limit, in s, since a fault's first run may compete with other work.
PATIENCE, LEAST_PATIENCE = 5, 60


def fail(text):
    print("mutants: " + text, file=sys.stderr)
    sys.exit(1)


def prepare(in_place):
    """A copy of the files that git knows or does not ignore, and a build of it. An earlier build is reused."""
    global TREE, BUILD
    if in_place:
        # --write changes docs.
        if subprocess.run(["git", "status", "--porcelain", "-uno", "--", ":!docs"], cwd=SOURCE,
                          capture_output=True).stdout:
            fail("changes that are not committed would be mixed with faults")
        TREE, BUILD = SOURCE, os.path.join(SOURCE, "build", "release")
        return
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=SOURCE, capture_output=True,
                            text=True, check=True).stdout.splitlines()
    for name in listed:
        source, copy = os.path.join(SOURCE, name), os.path.join(TREE, name)
        if not os.path.isfile(source):
            continue
        os.makedirs(os.path.dirname(copy), exist_ok=True)
        with open(source, "rb") as file:
            content = file.read()
        if name == "CMakeLists.txt":
            content = content.replace(b" -Werror", b"")  # a fault may leave a variable unused
        if os.path.exists(copy):
            with open(copy, "rb") as file:
                if file.read() == content:
                    continue
        with open(copy, "wb") as file:
            file.write(content)
        shutil.copymode(source, copy)
    subprocess.run(["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DCMAKE_UNITY_BUILD=ON", "-DFASCICLE_ALONE=ON", "-DFASCICLE_TESTS=ON"],
                   check=True, stdout=subprocess.DEVNULL)


def built(targets):
    return subprocess.run(["ninja", "-C", BUILD, *targets], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL).returncode == 0


class DoesNotBuild(Exception):
    pass


def names_of(test):
    """The tests of a program that its arguments choose."""
    listed = subprocess.run([os.path.join(BUILD, test[0]), *test[1:], "--gtest_list_tests"], capture_output=True,
                            text=True, check=True).stdout
    names, group = [], ""
    for line in listed.splitlines():
        word = line.split("#")[0].strip()
        if line.startswith("  "):
            names.append(group + word)
        elif word.endswith("."):
            group = word
    return [name for name in names if "DISABLED_" not in name]


def started(test, names, shard, temporary):
    """A process that runs every SHARDS-th of these tests, in a folder of its own. (gtest's own sharding would also
    divide the tests of a program that starts itself.)"""
    folder = os.path.join(temporary, str(shard))
    os.makedirs(folder, exist_ok=True)
    environment = {**os.environ, "TMPDIR": folder, "FASCICLE_CACHE_DIR": os.path.join(folder, "cache")}
    with open(os.path.join(folder, "text"), "w") as text:
        return subprocess.Popen([os.path.join(BUILD, test[0]), "--gtest_filter=" + ":".join(names[shard::SHARDS]),
                                 "--gtest_brief=1", "--gtest_fail_fast"], stdout=text, stderr=subprocess.STDOUT,
                                cwd=folder, env=environment, start_new_session=True)


def failure(test, temporary, limit=None):
    """The name of a failing test of this program; None if all pass. The first failure ends all shards, as do `limit`
    seconds."""
    try:
        names = names_of(test)
    except subprocess.CalledProcessError:
        return test[0] + " does not start"
    if not names:
        fail(test[0] + " has none of these tests")
    shards = {shard: started(test, names, shard, temporary) for shard in range(min(SHARDS, len(names)))}
    running, found, begin = dict(shards), None, time.monotonic()
    try:
        while running and found is None:
            time.sleep(0.05)
            for shard, process in list(running.items()):
                if process.poll() is None:
                    continue
                del running[shard]
                if process.returncode != 0:
                    with open(os.path.join(temporary, str(shard), "text"), errors="replace") as file:
                        name = re.search(r"^\[  FAILED  \] (\S+)", file.read(), re.MULTILINE)
                    found = name.group(1) if name else "%s ended with %d" % (test[0], process.returncode)
            if running and limit and time.monotonic() > begin + limit:
                found = test[0] + ": does not end"
    finally:
        for process in running.values():
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    return found


def first_that_fails(tests, temporary, usual):
    """The name of the first failing test; None if all pass. Builds each program just before it runs. `usual` holds the
    seconds that these programs take on the unchanged sources, and gets those that it lacks."""
    for test in tests:
        if not built([test[0], *STARTED.get(test[0], ())]):
            raise DoesNotBuild
        begin = time.monotonic()
        found = failure(test, temporary, max(LEAST_PATIENCE, PATIENCE * usual[test]) if test in usual else None)
        if found:
            return found
        usual.setdefault(test, time.monotonic() - begin)
    return None


def places(patterns):
    """Every (file, line, mutated line) where a fault can be planted."""
    found = []
    for pattern in patterns:
        for path in sorted(glob.glob(os.path.join(SOURCE, pattern))):
            with open(path) as file:
                lines = file.read().splitlines()
            for number, line in enumerate(lines):
                code = line.split("//")[0].rstrip()
                if not code or code.lstrip().startswith(("#", "*", "throw", "fail(")) or '"' in code:
                    continue
                name = os.path.relpath(path, SOURCE)
                for old, new in SWAPS:
                    if name.startswith("shaders/"):
                        new = BOUNDS.get(old, new)
                    for match in re.finditer(old, code):
                        found.append((name, number, code[:match.start()] + new + code[match.end():]))
                if STATEMENT.match(code):
                    found.append((name, number, re.match(r"\s*", code).group() + ";"))
    return found


def reasons():
    """{(file, original line, mutated line): why it may survive}"""
    with open(os.path.join(HERE, "living.txt")) as file:
        rows = [line.rstrip("\n").split("\t") for line in file if line.strip() and not line.startswith("#")]
    for row in rows:
        if len(row) != 4:
            fail("living.txt: a row has %d columns, and not 4: %s" % (len(row), row))
    return {tuple(row[:3]): row[3] for row in rows}


def as_row(name, number, line, made):
    """The fault as the page lists it."""
    return ["`%s:%d`" % (name, number), *("`%s`" % text.strip().replace("|", "\\|") for text in (line, made))]


def listed(room, rows):
    """[(file, line number, mutated line), line] of these rows of the page."""
    found = []
    for name, number, made in places(ROOMS[room][0]):
        with open(os.path.join(SOURCE, name)) as file:
            line = file.read().split("\n")[number]
        if as_row(name, number + 1, line, made) in [row[:3] for row in rows]:
            found.append(((name, number, made), line))
    if len(found) != len(rows):
        fail("%s: %d of %d faults that survived are no longer there; run the room anew" % (
            room, len(rows) - len(found), len(rows)))
    return found


def try_room(room, choices, count, temporary):
    """[(file, line number, line, mutated line, test that found it)] of `count` faults of these that compile."""
    tests, usual = ROOMS[room][1], {}
    try:
        wrong = first_that_fails(tests, temporary, usual)
    except DoesNotBuild:
        fail(room + ": the sources as they are do not build")
    if wrong:
        fail("%s: the sources as they are fail %s" % (room, wrong))
    tried, lines = [], set()
    for name, number, made in choices:
        if len(tried) == count:
            break
        if (name, number) in lines:
            continue
        lines.add((name, number))
        path = os.path.join(TREE, name)
        with open(path) as file:
            whole = file.read()
        rows = whole.split("\n")
        line = rows[number]
        rows[number] = made
        begin = time.monotonic()
        try:
            with open(path, "w") as file:
                file.write("\n".join(rows))
            found = first_that_fails(tests, temporary, usual)
        except DoesNotBuild:
            continue  # does not compile
        finally:
            with open(path, "w") as file:
                file.write(whole)
        tried.append((name, number + 1, line.strip(), made.strip(), found))
        print("%s:%d: `%s` as `%s`: %s (%.0f s)" % (name, number + 1, line.strip(), made.strip(),
                                                   "found by " + found if found else "LIVES",
                                                   time.monotonic() - begin), flush=True)
    return tried


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("room", nargs="*", choices=[[], *ROOMS])
    parser.add_argument("--count", type=int, default=40, help="of each room")
    parser.add_argument("--again", action="store_true", help="only the faults that survived")
    parser.add_argument("--write", action="store_true", help="the rooms' figures into docs/tests.md")
    parser.add_argument("--in-place", action="store_true")
    asked = parser.parse_args()
    # The source is restored, and tests in an endless loop end, also when this ends.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    seed = int(os.environ.get("FASCICLE_SEED", str(time.time_ns() % 1000000)))
    known = reasons()
    prepare(asked.in_place)
    status, ran = 0, {}
    for room in asked.room or ROOMS:
        earlier = page.kept("mutants").get("rooms", {}).get(room)
        living = []
        if asked.again:
            if not earlier:
                fail(room + ": nothing is known of an earlier run")
            choices = []
            for place, line in listed(room, [row for row in earlier["living"] if row[-1] == UNKNOWN]):
                name, number, made = place
                reason = known.get((name, line.strip(), made.strip()))
                if reason:
                    living.append([*as_row(name, number + 1, line, made), reason])
                else:
                    choices.append(place)
            count = len(choices)
        else:
            random.seed("%d %s" % (seed, room))  # a room's faults do not depend on which others run
            choices, count = places(ROOMS[room][0]), asked.count
            random.shuffle(choices)
        # In memory if possible: tests wait for disks.
        with tempfile.TemporaryDirectory(prefix="fascicle-mutants-", dir=SHARED if os.path.isdir(SHARED) else None,
                                         ignore_cleanup_errors=True) as temporary:
            tried = try_room(room, choices, count, temporary)
        living += [[*as_row(name, number, line, made), known.get((name, line, made), UNKNOWN)]
                   for name, number, line, made, test in tried if not test]
        one = {"planted": len(tried), "living": living, "seed": seed, "commit": page.commit()}
        if asked.again:
            one = {**earlier, "living": [row for row in earlier["living"] if row[-1] != UNKNOWN] + living,
                   "commit": one["commit"]}
        one["equivalent"] = sum(row[-1] != UNKNOWN for row in one["living"])
        one["found"] = one["planted"] - len(one["living"])
        is_same = earlier and (earlier["seed"], earlier["planted"]) == (one["seed"], one["planted"])
        one["first"] = earlier["first"] if is_same else one["found"]
        ran[room] = one
        if asked.write:  # other rooms keep their earlier figures
            page.put("mutants", {"rooms": {**page.kept("mutants").get("rooms", {}), room: one}})
        due = one["planted"] - one["equivalent"]
        if one["found"] < LEAST * due:
            print("mutants: %s: %s were found, below %s" % (room, page.share(one["found"], due), page.share(LEAST, 1)))
            status = 1
        for row in one["living"]:
            if row[-1] == UNKNOWN:
                print("mutants: %s: nobody has said why it lives (living.txt)" % row[0])
                status = 1
    print("seed %d\n%s" % (seed, page.mutants_text({"rooms": ran})))
    return status


if __name__ == "__main__":
    sys.exit(main())
