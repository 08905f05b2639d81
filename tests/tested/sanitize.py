"""Runs the tests of a build with sanitizers, and counts the reports of every process that a test starts.

sanitize.py PRESET [--write] [SUITE...]: build/PRESET holds the build; a suite is the first part of its tests' names, as
in `bake`; default: all. First, control programs with one planted flaw each, compiled in the same way, must be reported.
--write: into docs/tests.md, suite by suite; suites that did not run keep their figures."""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

import page
import suite

HERE = os.path.dirname(os.path.abspath(__file__))
# {preset: {text in the report: body of main()}} of the planted flaws.
PLANTED = {
    "asan": {"heap-buffer-overflow": "auto* a = new volatile char[8]; char c = a[8 + argc]; delete[] a; return c;",
             "heap-use-after-free": "auto* a = new volatile char[8]; delete[] a; return a[argc];",
             "detected memory leaks": "auto* volatile a = new char[argc]; a = nullptr; return 0;",
             "signed integer overflow": "volatile int a = 2147483647; a = a + argc; return 0;"},
    "tsan": {"data race": "int a = 0; std::thread other([&] { ++a; }); ++a; other.join(); return a * 0;"},
}
FLAGS = {"asan": "address,undefined", "tsan": "thread"}


def environment(preset, log):
    """Reports go to files LOG.PID. The undefined behaviour sanitizer writes no such file next to the address sanitizer,
    so it aborts instead, which no test expects."""
    suppressions = os.path.join(HERE, preset + "-suppressions.txt")
    options = "log_path=%s" % log
    made = {**os.environ}
    if preset == "asan":
        made["ASAN_OPTIONS"] = options + ":detect_leaks=1:strict_init_order=1"
        made["UBSAN_OPTIONS"] = "halt_on_error=1:abort_on_error=1:print_stacktrace=1"
    else:
        made["TSAN_OPTIONS"] = options + ":second_deadlock_stack=1" + (
            ":suppressions=" + suppressions if os.path.exists(suppressions) else "")
    return made


def reports_in(folder):
    """{first descriptive line: how often} of the reports."""
    found = {}
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), errors="replace") as file:
            text = file.read()
        said = re.findall(r"^(?:SUMMARY: .*|.*runtime error: .*)$", text, re.MULTILINE)
        for line in said or (["%s: %s" % (name, text[:200])] if text.strip() else []):
            found[line] = found.get(line, 0) + 1
    return found


def control(preset, temporary):
    """Each planted flaw must be reported."""
    for word, body in PLANTED[preset].items():
        source, program = os.path.join(temporary, "planted.cpp"), os.path.join(temporary, "planted")
        with open(source, "w") as file:
            file.write("#include <thread>\nint main(int argc, char**) { %s }\n" % body)
        subprocess.run(["g++", "-O0", "-g1", "-std=c++20", "-pthread", "-fsanitize=" + FLAGS[preset], source,
                        "-o", program], check=True)
        folder = tempfile.mkdtemp(dir=temporary)
        done = subprocess.run([program], env=environment(preset, os.path.join(folder, "of")), stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, check=False)
        text = done.stderr if done.returncode == -signal.SIGABRT else ""
        for name in os.listdir(folder):
            with open(os.path.join(folder, name), errors="replace") as file:
                text += file.read()
        if word not in text:
            sys.exit("sanitize: %s: a planted flaw went unseen: %s" % (preset, word))


def hold_instrumented(preset):
    """Fails if the build has no sanitizer: it would report nothing."""
    word = {"asan": b"__asan_report_load8", "tsan": b"__tsan_read8"}[preset]
    for name in ("fascicle", "test_bake"):
        with open(os.path.join(page.ROOT, "build", preset, name), "rb") as file:
            if word not in file.read():
                sys.exit("sanitize: build/%s/%s was built without the sanitizer" % (preset, name))


def try_suite(preset, name):
    """The suite's figures; prints its reports."""
    logs = os.path.join(page.ROOT, "build", preset, "reports", name)
    shutil.rmtree(logs, ignore_errors=True)
    os.makedirs(logs)
    count = suite.run(preset, ["-R", r"^%s\." % name], environment(preset, os.path.join(logs, "of")))
    reports = reports_in(logs)
    for line, often in sorted(reports.items(), key=lambda one: -one[1]):
        print("%5d times: %s" % (often, line))
    one = {"tests": count["tests"], "skipped": count["skipped"], "failed": count["failures"],
           "reports": sum(reports.values()), "seconds": round(count["seconds"]), "commit": page.commit()}
    print("%s: %s: %d tests, %d skipped, %d failed, %d reports (%.0f s); %s" % (
        preset, name, one["tests"], one["skipped"], one["failed"], one["reports"], one["seconds"], logs), flush=True)
    return one


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in PLANTED:
        sys.exit("usage: sanitize.py asan|tsan [--write] [SUITE...]")
    preset, asked = sys.argv[1], sys.argv[2:]
    write = "--write" in asked
    if write:
        asked.remove("--write")
    with tempfile.TemporaryDirectory(prefix="fascicle-sanitize-") as temporary:
        control(preset, temporary)
    hold_instrumented(preset)
    names = suite.names(preset)
    unknown = [name for name in asked if name not in names]
    if unknown:
        sys.exit("sanitize: no such suite: %s; there are %s" % (", ".join(unknown), ", ".join(names)))
    status = 0
    for name in asked or names:
        one = try_suite(preset, name)
        if one["reports"] or one["failed"] or not one["tests"]:
            status = 1
        if write:
            presets = page.kept("sanitizers").get("presets", {})
            presets[preset] = {**presets.get(preset, {}), name: one}
            page.put("sanitizers", {"presets": presets})
    return status


if __name__ == "__main__":
    sys.exit(main())
