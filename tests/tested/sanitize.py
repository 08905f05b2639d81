"""Runs the test suite of a build with sanitizers, and counts the reports of every process that a test starts.

sanitize.py PRESET [--write] [CTEST ARGUMENTS...]: build/PRESET holds the build. First, control programs with one
planted flaw each, compiled in the same way, must be reported. --write: into docs/tests.md."""

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


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in PLANTED:
        sys.exit("usage: sanitize.py asan|tsan [--write] [CTEST ARGUMENTS...]")
    preset, arguments = sys.argv[1], sys.argv[2:]
    write = "--write" in arguments
    if write:
        arguments.remove("--write")
    temporary = tempfile.mkdtemp(prefix="fascicle-sanitize-")
    control(preset, temporary)
    hold_instrumented(preset)
    logs = os.path.join(page.ROOT, "build", preset, "reports")
    shutil.rmtree(logs, ignore_errors=True)
    os.makedirs(logs)
    count = suite.run(preset, arguments, environment(preset, os.path.join(logs, "of")))
    reports = reports_in(logs)
    for line, often in sorted(reports.items(), key=lambda one: -one[1]):
        print("%5d times: %s" % (often, line))
    print("%s: %d tests, %d skipped, %d failed, %d reports (%.0f s); %s" % (
        preset, count["tests"], count["skipped"], count["failures"], sum(reports.values()), count["seconds"], logs))
    shutil.rmtree(temporary)
    if write:
        presets = page.kept("sanitizers").get("presets", {})
        presets[preset] = {"which": suite.which(arguments), "tests": count["tests"], "skipped": count["skipped"],
                           "failed": count["failures"], "reports": sum(reports.values()), "seconds": count["seconds"]}
        page.put("sanitizers", {"presets": presets})
    return 1 if reports or count["failures"] else 0


if __name__ == "__main__":
    sys.exit(main())
