#!/usr/bin/env python3
"""Checks the hardening of built programs and libraries (cmake/hardened.cmake).

    python3 tests/house/hardened.py COMPILER SOURCE_FOLDER COMPILE_COMMANDS FILE...

Every command in COMPILE_COMMANDS (CMake's compile_commands.json) except those of tests must have the flags: statically
linked libraries contain guards of their own, so a binary says little about our code.

Every FILE must be position-independent, have its relocations bound at start and then read-only, a non-executable stack,
no segment that is both writable and executable, stack protectors, fortified calls of the C library, no run path or one
relative to the file, and must not contain the path of the sources. The controls: a tiny program without hardening fails
every check, and one with it passes all.
"""
import json
import pathlib
import platform
import re
import shlex
import subprocess
import sys
import tempfile

TINY = """
#include <stdio.h>
#include <string.h>
int main(int count, char** words) {
  char text[16];
  strcpy(text, words[count - 1]);
  puts(text);
  return puts(__FILE__) < 0;
}
"""
BARE = "int written = 1; int main(void) { return written++; }"
SOFT = ("-O2", "-no-pie", "-fno-stack-protector", "-U_FORTIFY_SOURCE", "-Wl,-z,norelro", "-Wl,-z,lazy",
        "-Wl,-z,execstack", "-Wl,-rpath,/somewhere/else")
ONE_SEGMENT = ("-O2", "-no-pie", "-static", "-nostdlib", "-Wl,-e,main", "-Wl,--omagic", "-Wl,-z,norelro")
HARD = ("-O2", "-fPIE", "-pie", "-fstack-protector-strong", "-U_FORTIFY_SOURCE", "-D_FORTIFY_SOURCE=2",
        "-Wl,-z,relro,-z,now,-z,noexecstack", "-Wl,-rpath,$ORIGIN")
ALL = {"position", "read-only", "bound", "stack", "segments", "guards", "sizes", "run path", "sources"}


def read(file, *what):
    return subprocess.run(["readelf", "--wide", *what, str(file)], check=True, capture_output=True, text=True).stdout


def names_path(data, path):
    """Whether the bytes contain an absolute path below this folder; ../../src/init.c is not below /src."""
    return re.search(rb"(?<![\w./-])" + re.escape(str(path).encode()) + b"/", data) is not None


def wanted_flags(compiler):
    """[(pattern of a flag's forms, the form wanted)]; -fcf-protection exists only on x86."""
    flags = [("-[DU]_FORTIFY_SOURCE.*", "-D_FORTIFY_SOURCE=2"),
             ("-f(no-)?stack-protector.*", "-fstack-protector-strong")]
    for name in ("stack-clash-protection", "cf-protection"):
        if subprocess.run([compiler, "-Werror", f"-f{name}", "-x", "c", "-c", "-o", "/dev/null", "/dev/null"],
                          capture_output=True).returncode == 0:
            flags.append((f"-f(no-)?{name}.*", f"-f{name}"))
        elif platform.machine() == "x86_64":
            sys.exit(f"{compiler} does not know -f{name}")
    return flags


def faults_of_command(command, flags):
    """The flags that a compile command lacks or undoes."""
    words = shlex.split(command)
    last = lambda pattern: next((word for word in reversed(words) if re.fullmatch(pattern, word)), "none")
    return [f"{last(pattern)}, not {wanted}" for pattern, wanted in flags
            if last(pattern) != wanted] + ["-O0"] * (last("-O.*") in ("none", "-O0"))


def faults_of_commands(commands, flags):
    """Checks all compile commands except those of tests, by their object folders."""
    faults, count = [], 0
    for entry in commands:
        name = re.search(r" -o (\S+)", entry["command"])[1]
        if not name.startswith("tests/"):
            count += 1
            faults += [f"{entry['file']} is compiled with {words}"
                       for words in faults_of_command(entry["command"], flags)]
    return faults or ([] if count else ["no command but those of tests"])


def faults_of(file, sources):
    """The protections that FILE lacks: names from ALL, with descriptions."""
    header, segments = read(file, "--file-header"), read(file, "--program-headers")
    dynamic, symbols = read(file, "--dynamic"), read(file, "--dyn-syms")
    faults = {}
    is_program = "INTERP" in segments
    flags = " ".join(re.findall(r"\(FLAGS(?:_1)?\)(.*)", dynamic))
    if not re.search(r"Type:\s+DYN", header) or (is_program and "PIE" not in flags):
        faults["position"] = "is loaded at a fixed place (-pie)"
    if "GNU_RELRO" not in segments:
        faults["read-only"] = "has relocations that stay writable (-z relro)"
    if not re.search(r"\b(BIND_)?NOW\b", flags):
        faults["bound"] = "binds its calls late (-z now)"
    stack = re.search(r"^\s+GNU_STACK\s+(?:0x\S+\s+){5}([RWE ]{3})", segments, re.M)
    if not stack or "E" in stack[1]:
        faults["stack"] = "has a stack that executes (-z noexecstack)"
    if any("W" in words and "E" in words
           for words in re.findall(r"^\s+LOAD\s+(?:0x\S+\s+){5}([RWE ]{3})", segments, re.M)):
        faults["segments"] = "has a segment that is written and executed"
    if not re.search(r"\b__stack_chk_(fail|guard)\b", symbols):
        faults["guards"] = "has no guards on its stack (-fstack-protector-strong)"
    # The Python module makes no calls that can be fortified.
    if not pathlib.Path(file).name.startswith("_fascicle") and not re.search(r"\b__(?!stack)\w+_chk\b", symbols):
        faults["sizes"] = "has no checks of sizes (-D_FORTIFY_SOURCE=2)"
    # CMake pads the build folder's run path with colons, to replace it on installation.
    for paths in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", dynamic):
        if any(path and not re.match(r"\$ORIGIN(/|$)", path) for path in paths.split(":")):
            faults["run path"] = f"looks for libraries in {paths}"
    if names_path(pathlib.Path(file).read_bytes(), sources):
        faults["sources"] = f"holds the path {sources} (-ffile-prefix-map)"
    return faults


def check_controls(compiler, flags):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        source, program = folder / "tiny.c", folder / "tiny"
        mapped = f"-ffile-prefix-map={folder}=."
        library = [flag for flag in HARD if flag not in ("-fPIE", "-pie", "-D_FORTIFY_SOURCE=2")] + ["-fPIC", "-shared"]
        # Only a statically linked program can have code and data in one segment.
        for text, options, wanted in ((TINY, SOFT, ALL - {"segments"}), (TINY, (*HARD, mapped), set()),
                                      (TINY, (*library, mapped), {"sizes"}),
                                      (BARE, (*ONE_SEGMENT, mapped), ALL - {"stack", "run path", "sources"})):
            source.write_text(text)
            subprocess.run([compiler, "-x", "c", *options, str(source), "-o", str(program)], check=True,
                           capture_output=True)
            found = faults_of(program, folder)
            if set(found) != wanted:
                sys.exit(f"the control with {' '.join(options)}: found {sorted(found)}, not {sorted(wanted)}")
    for data, is_named in ((b"\0/src/init.c", True), (b"\0../../src/init.c", False), (b"\0/src2/init.c", False)):
        if names_path(data, "/src") != is_named:
            sys.exit(f"the control with {data}: it must {'' if is_named else 'not '}be a path in /src")
    hard = f"c++ -O2 -U_FORTIFY_SOURCE {' '.join(wanted for _, wanted in flags)} -o host/a.o -c a.cpp"
    for command, count in ((hard, 0), (hard.replace("=2", "=1"), 1), (hard + " -U_FORTIFY_SOURCE", 1),
                           (hard + " -fno-stack-protector -O0", 2), ("c++ -o host/a.o -c a.cpp", 1 + len(flags)),
                           *((hard.replace(wanted, ""), 1) for _, wanted in flags),
                           (hard.replace("host/", "tests/"), 1)):
        if len(faults_of_commands([{"file": "a.cpp", "command": command}], flags)) != count:
            sys.exit(f"the control with {command}: not {count} faults")


def main(compiler, sources, commands, files):
    flags = wanted_flags(compiler)
    check_controls(compiler, flags)
    faults = faults_of_commands(json.loads(pathlib.Path(commands).read_text()), flags)
    faults += [f"{file} {words}" for file in files for words in faults_of(file, sources).values()]
    print("\n".join(faults) or f"{len(files)} files are hardened")
    return 1 if faults else 0


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]))
