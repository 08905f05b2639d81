"""Runs the readers' fuzz targets, and prints or writes the results.

fuzz.py [TARGET...] [--runs N] [--seconds N] [--jobs N] [--processes N] [--write] | --list: FASCICLE_FUZZ_BUILD names
the build folder of the preset `fuzz`. Its folder `corpus` keeps inputs that reached new code, `found` inputs that
exposed a flaw, `runs` how far a run of --runs came that was stopped: it goes on, unless the target was built anew.
--write: into the page in docs; targets that did not run keep their line. --list: only prints the targets."""

import argparse
import concurrent.futures
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
PAGE_FILE = os.path.join(HERE, "..", "..", "docs", "fuzzing.md")
BUILD = os.path.abspath(os.environ.get("FASCICLE_FUZZ_BUILD", "build/fuzz"))

# {target: what it reads}, for the table.
TARGETS = {
    "medit": "MEDIT `.mesh`", "tetgen": "TetGen `.node` and `.ele`", "gmsh": "Gmsh `.msh`", "vtu": "VTK `.vtu`",
    "off": "`.off`", "obj": "`.obj`", "ply": "`.ply`", "stl": "`.stl`",
    "gltf": "`.glb`, `.gltf`: character, rig, looks, documents handed on",
    "exports": "a bake's `character.glb`: one thing that an export or a bake makes of it, by the first byte",
    "picture": "PNG and JPEG of textures",
    "scene": "scene files", "set": "values of `--set`", "jobs": "lists of jobs", "paint": "paint files",
    "frames": "`frames.fascicle`", "model": "`model.fascicle`", "checkpoint": "`checkpoint`",
    "start": "a kept start", "manifest": "`manifest.json`", "metrics": "`metrics.csv`",
    "record": "a job's record", "batch": "`batch.json`", "plan": "`plan.json`", "body": "a kept body",
    "report": "a kept model's report", "results": "results of `fascicle bench`",
    "state": "a solver's saved state", "filling": "the mesher's filling of a surface",
    "findings": "the mesher's report", "wrap": "the mesher's wrap",
    "message": "messages to the studio", "session": "the studio's `session.json`",
}
# No seed is longer. test_fuzz reads long files, by growing seeds to a mebibyte; the fuzzer is faster with short ones.
MOST_BYTES = 8192
MOST_MEBIBYTES, MOST_SECONDS = 512, 10
# Of all variants of a seed, a few thousand.
MOST_SECONDS_OF_NUMBERS = 600
# The entropic schedule tracks rare features, which takes most of the time for a reader with many. Without it gltf reads
# 2.5 times as many files per second, and reaches as much code in a minute.
SCHEDULE = ("-entropic=0",)
# The preset does not record compared values (trace-cmp) either: gltf reads 1.5 times as many files per second, and
# reaches as much code in half a minute (three seeds).
# A long run goes in pieces, so that it can be stopped: files of one process.
PIECE = 250000
CONTROL, CONTROL_OF_NUMBERS, RUNS_OF_CONTROL = "planted", "planted_number", 2000000
# {file that exposes a flaw of the planted reader: what the fuzzer must say}
PLANTED = {"bone": "heap-buffer-overflow", "fat": "terminate called after throwing", "leak": "detected memory leaks",
           "overflow": "signed integer overflow", "endless": "timeout after", "huge": "out-of-memory"}

PAGE = """# Fuzzing

Readers of files from strangers have targets for clang's libFuzzer (`tests/fuzz`). Address, leak and undefined behaviour
sanitizers run in the same process. What the mesher returns has targets too: it ran on a stranger's surface. FBX and
Collada have none: `fascicle-convert` reads them with assimp in a sandbox.

A reader accepts a file, or refuses it with the exception that its C++ header names and a message of one line. Anything
else is a flaw: another exception, a read or write out of bounds, a leak, undefined behaviour, an allocation or a
process of more than %d MiB, or a file that takes more than %d s. The process also holds the sanitizers' shadow memory,
the corpus and recently freed memory, so a reader itself has less than that.

PNG and our own file formats carry checksums. Their targets correct them, so that the fuzzer gets past them. One change
in sixteen replaces a number in a text, with 1e300, -1 or 2^64 for example; changes of single bytes rarely make these.
Before the fuzzer starts, each number of each seed is replaced in all these ways. Each run first checks that the fuzzer
finds the flaws of planted readers: a read past the end, an undocumented exception, the same one that only a replaced
number causes, a leak, a signed overflow, an endless loop and 600 MiB at once.

Files are at most as long as the table says, because the fuzzer tries short files much faster. No seed is longer.
`test_fuzz`, which any compiler builds, reads the seeds and all earlier finds, damages them by fixed rules, and extends
them to 1 MiB, where a reader may take %d s and %d MiB of C++ memory. CI runs it, but not the fuzzer itself, whose
build alone takes longer than CI may.

| target | what it reads | files | at most | time | processes | files/s | peak memory | slowest | flaws | commit |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
%s
Each line is the last run of its target, on %s, with %s. The peak memory is that of one process.
`./do fuzz --write` updates this page; `./do fuzz TARGET... --runs 10000000 --processes 8` runs targets for longer, each
in eight processes, which share what they find. Such a run may be stopped: it goes on where it was, unless the target
was built anew. What once broke a reader is kept in `tests/fuzz/kept`, and `test_fuzz` reads it in every build.
"""


def environment(temporary):
    # The quarantine holds freed memory to detect later uses. The sanitizer's default is half of the memory that a
    # target may take. Recording whole stacks of allocations would take 7 % of the time: to see them, read a find again
    # with malloc_context_size=30.
    asan = "quarantine_size_mb=32:detect_leaks=1:allocator_may_return_null=0:malloc_context_size=2"
    return {**os.environ, "TMPDIR": temporary, "ASAN_OPTIONS": asan, "UBSAN_OPTIONS": "print_stacktrace=1"}


def command(target, *more):
    return [os.path.join(BUILD, "fuzz_" + target), "-rss_limit_mb=%d" % MOST_MEBIBYTES,
            "-malloc_limit_mb=%d" % MOST_MEBIBYTES, "-timeout=%d" % MOST_SECONDS,
            "-artifact_prefix=%s/found/%s-" % (BUILD, target), *more]


def last(pattern, text, otherwise=0):
    found = re.findall(pattern, text, re.MULTILINE)
    return int(found[-1]) if found else otherwise


def fuzzed(target, k, ends, temporary):
    """(files, peak MiB, slowest file in s, flaws) of one process. Processes share what they find."""
    corpus = os.path.join(BUILD, "corpus", target)
    begin_with = [folder for folder in (os.path.join(BUILD, "seeds", target), os.path.join(HERE, "kept", target))
                  if os.path.isdir(folder)]
    log = os.path.join(BUILD, "logs", "%s%s.txt" % (target, "-%d" % k if k else ""))
    with open(log, "w") as file:
        done = subprocess.run(
            command(target, "-max_len=%d" % MOST_BYTES, "-len_control=100", "-print_final_stats=1",
                    "-reduce_inputs=1", *SCHEDULE, *ends, corpus, *begin_with),
            stdout=file, stderr=file, env=environment(temporary))
    with open(log, errors="replace") as file:
        text = file.read()
    if done.returncode:
        said = re.findall(r"^(?:.*(?:ERROR|SUMMARY|runtime error|what\(\)).*)$", text, re.MULTILINE)
        print("\n".join(["%s: %s" % (target, line) for line in said[:3]] + ["%s: all of it: %s" % (target, log)]),
              file=sys.stderr, flush=True)
    files = last(r"^stat::number_of_executed_units: (\d+)", text, last(r"^#(\d+)\b", text))
    return (files, last(r"^stat::peak_rss_mb: +(\d+)", text), last(r"^stat::slowest_unit_time_sec: +(\d+)", text),
            1 if done.returncode else 0)


class SoFar:
    """What a run found so far. Its file says so to the next, which goes on if the same program reads the files."""

    def __init__(self, target, goes_on):
        os.makedirs(os.path.join(BUILD, "runs"), exist_ok=True)
        self.path = os.path.join(BUILD, "runs", target + ".json")
        with open(os.path.join(BUILD, "fuzz_" + target), "rb") as file:
            self.program = hashlib.sha256(file.read()).hexdigest()
        self.files = self.seconds = self.mebibytes = self.slowest = self.flaws = 0
        if not goes_on or not os.path.exists(self.path):
            return
        with open(self.path) as file:
            found = json.load(file)
        if found.pop("program") == self.program:
            vars(self).update(found)
            print("%-10s goes on after %d files" % (target, self.files), flush=True)

    def add(self, of_processes, seconds):
        files, mebibytes, slowest, flaws = zip(*of_processes)
        self.files += sum(files)
        self.seconds += seconds
        self.mebibytes, self.slowest = max(self.mebibytes, *mebibytes), max(self.slowest, *slowest)
        self.flaws = max(flaws)

    def keep(self):
        with open(self.path + ".new", "w") as file:
            json.dump({key: value for key, value in vars(self).items() if key not in ("path", "flaws")}, file)
        os.replace(self.path + ".new", self.path)

    def forget(self):
        if os.path.exists(self.path):
            os.remove(self.path)


def each_number_is_read(target, temporary):
    """Whether the target reads its seeds with each number in them replaced. The fuzzer meets few of these by chance."""
    folder = os.path.join(BUILD, "seeds", target)
    log = os.path.join(BUILD, "logs", target + "-numbers.txt")
    with open(log, "w") as file:
        done = subprocess.run(command(target, "-timeout=%d" % MOST_SECONDS_OF_NUMBERS,
                                      *sorted(os.path.join(folder, name) for name in os.listdir(folder))),
                              stdout=file, stderr=file,
                              env={**environment(temporary), "FASCICLE_FUZZ_EACH_NUMBER": "1"})
    if done.returncode:
        print("%s: a strange number in a seed: all of it: %s" % (target, log), file=sys.stderr, flush=True)
    return done.returncode == 0


def run(target, asked, temporary):
    """(target, processes, files, seconds, peak MiB of one process, slowest file in s, flaws) of one target."""
    os.makedirs(os.path.join(BUILD, "corpus", target), exist_ok=True)
    if not each_number_is_read(target, temporary):
        return (target, asked.processes, 0, 0, 0, 0, 1)
    n = asked.processes
    so_far = SoFar(target, goes_on=bool(asked.runs))
    stops = time.monotonic() + asked.seconds if asked.seconds else None
    with concurrent.futures.ThreadPoolExecutor(n) as pool:
        while True:
            begin = time.monotonic()
            left = asked.runs and asked.runs - so_far.files
            ends = ["-runs=%d" % min(PIECE, -(-left // n))] if left else []
            ends += ["-max_total_time=%d" % max(1, round(stops - begin))] if stops else []
            found = list(pool.map(lambda k: fuzzed(target, k, ends, temporary), range(n)))
            so_far.add(found, time.monotonic() - begin)
            is_over = so_far.flaws or (stops and time.monotonic() > stops - 1)
            if is_over or (asked.runs and so_far.files >= asked.runs):
                break
            so_far.keep()
    if so_far.flaws or not asked.runs or so_far.files >= asked.runs:
        so_far.forget()
    else:
        so_far.keep()
    result = (target, n, so_far.files, so_far.seconds, so_far.mebibytes, so_far.slowest, so_far.flaws)
    print("%-10s %2d %10d files %6.0f s %5d MiB %3d s the slowest %d flaws" % result, flush=True)
    return result


def control_is_found(temporary):
    """Controls: the planted reader's flaws are found, each in its file, and one by fuzzing."""
    for word, said in PLANTED.items():
        with tempfile.NamedTemporaryFile(dir=temporary) as file:
            file.write(word.encode())
            file.flush()
            limit = ["-timeout=1"] if word == "endless" else []
            read = subprocess.run(command(CONTROL, *limit, file.name), capture_output=True, text=True,
                                  errors="replace", env=environment(temporary))
        if read.returncode == 0 or said not in read.stderr:
            print("control: '%s': not seen: %s\n%s" % (word, said, read.stderr), file=sys.stderr)
            return False
    search = subprocess.run(command(CONTROL, "-max_len=16", "-runs=%d" % RUNS_OF_CONTROL), capture_output=True,
                            text=True, errors="replace", env=environment(temporary))
    if search.returncode == 0:
        print("control: not found in %d files" % RUNS_OF_CONTROL, file=sys.stderr)
        return False
    print("%-10s %10d files until it was found" % ("control", last(r"^#(\d+)\b", search.stderr)), flush=True)
    return number_is_found(temporary)


def number_is_found(temporary):
    """Controls: the flaw of the reader of a number is found, by the fuzzer and among all replaced numbers."""
    folder = tempfile.mkdtemp(dir=temporary)
    seed = os.path.join(folder, "seed")
    with open(seed, "w") as file:
        file.write("length 5")
    for arguments, each in ((["-max_len=16", "-runs=%d" % RUNS_OF_CONTROL, folder], {}),
                            ([seed], {"FASCICLE_FUZZ_EACH_NUMBER": "1"})):
        found = subprocess.run(command(CONTROL_OF_NUMBERS, *arguments), capture_output=True, text=True,
                               errors="replace", env={**environment(temporary), **each})
        if found.returncode == 0 or "planted number" not in found.stderr:
            print("control: the planted number was not found\n%s" % found.stderr, file=sys.stderr)
            return False
    return True


def commit():
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=HERE, capture_output=True, text=True,
                          check=False).stdout.strip() or "unknown"


def line_of(target, processes, files, seconds, mebibytes, slowest, flaws):
    return "| `%s` | %s | %s | %d B | %.0f s | %d | %s | %d MiB | %s | %d | %s |\n" % (
        target, TARGETS[target], "{:,}".format(files), MOST_BYTES, seconds, processes,
        "{:,.0f}".format(files / max(seconds, 0.1)), mebibytes,
        "under 1 s" if slowest == 0 else "%d s" % slowest, flaws, commit())


def write_page(results):
    lines = {}
    if os.path.exists(PAGE_FILE):
        with open(PAGE_FILE) as file:
            lines = {found.group(1): line for line in file if (found := re.match(r"\| `(\w+)` \|", line))}
    lines.update({result[0]: line_of(*result) for result in results})
    clang = subprocess.run(["clang", "--version"], capture_output=True, text=True).stdout.split("\n")[0]
    version = re.search(r"clang version (\d+)", clang)
    text = PAGE % (MOST_MEBIBYTES, MOST_SECONDS, MOST_SECONDS, MOST_MEBIBYTES,
                   "".join(lines[target] for target in TARGETS if target in lines),
                   platform.machine(),
                   "clang " + version.group(1) if version else "clang")
    with open(PAGE_FILE + ".new", "w") as file:
        file.write(text)
    os.replace(PAGE_FILE + ".new", PAGE_FILE)


def main():
    parser = argparse.ArgumentParser(prog="./do fuzz", description=__doc__.splitlines()[0])
    parser.add_argument("target", nargs="*", choices=[[], *TARGETS])
    parser.add_argument("--runs", type=int, help="files a target")
    parser.add_argument("--seconds", type=int, help="seconds a target (60, or no limit with --runs)")
    parser.add_argument("--jobs", type=int, default=1, help="targets at a time (1)")
    parser.add_argument("--processes", type=int, default=1, help="processes a target (1)")
    parser.add_argument("--write", action="store_true", help="write docs/fuzzing.md")
    parser.add_argument("--list", action="store_true", help="print the targets and end")
    asked = parser.parse_args()
    if asked.processes < 1:
        parser.error("--processes: must be at least 1")
    if not asked.runs and asked.seconds is None:
        asked.seconds = 60
    if asked.list:
        print(" ".join(TARGETS))
        return 0
    for folder in ("found", "logs"):
        os.makedirs(os.path.join(BUILD, folder), exist_ok=True)
    # In memory if possible: readers of paths write and read a file for every input.
    temporary = tempfile.mkdtemp(prefix="fascicle-fuzz-", dir="/dev/shm" if os.path.isdir("/dev/shm") else None)
    try:
        shutil.rmtree(os.path.join(BUILD, "seeds"), ignore_errors=True)
        subprocess.run([os.path.join(BUILD, "fuzz_seeds"), os.path.join(BUILD, "seeds")], check=True,
                       env=environment(temporary))
        if not control_is_found(temporary):
            return 1
        flaws = 0
        with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
            started = [pool.submit(run, target, asked, temporary) for target in asked.target or TARGETS]
            # Each as it ends: a run of hours may be stopped.
            for done in concurrent.futures.as_completed(started):
                flaws += done.result()[-1]
                if asked.write:
                    write_page([done.result()])
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return 1 if flaws else 0


if __name__ == "__main__":
    sys.exit(main())
