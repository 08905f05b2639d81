"""Bakes under Valgrind, which reports invalid accesses and leaks."""

import os
import re
import shutil
import subprocess

from bakes import DONE, PROGRAM, hold, must_be_found
from hostile_names import named_character

FOUND = 99
VALGRIND = ["valgrind", "-q", "--error-exitcode=%d" % FOUND, "--leak-check=full", "--show-leak-kinds=definite",
            "--errors-for-leak-kinds=definite"]
# Faults that Valgrind must find, one per argument.
FAULTY = """
#include <cstdlib>
#include <cstring>
int main(int, char** arguments) {
  char* volatile bytes = static_cast<char*>(std::malloc(16));
  if (std::strcmp(arguments[1], "read") == 0) return bytes[16] == 1 ? 2 : (std::free(bytes), 0);
  if (std::strcmp(arguments[1], "unset") == 0) return bytes[3] == 1 ? 2 : (std::free(bytes), 0);
  bytes = nullptr;
  return 0;
}
"""
# Valgrind 3.19 does not support AVX-512.
UNKNOWN_LEVELS = ("avx512",)


def under_valgrind(command, environment, log):
    """(completed process, Valgrind's log)."""
    done = subprocess.run([*VALGRIND, "--log-file=" + log, *command], capture_output=True, text=True, env=environment)
    with open(log, errors="replace") as file:
        return done, file.read()


def hold_clean(command, environment, log):
    done, said = under_valgrind(command, environment, log)
    # Any output fails, including warnings such as an unknown instruction.
    hold(done.returncode == DONE and not said.strip(), "%s exited with %d: %s\n%s"
         % (" ".join(command), done.returncode, done.stderr[-1000:], said[:3000]))


def memory(bakes, count):
    """Valgrind runs `inspect` and `bake` of a small character and of a bar on the CPU, at each CPU level that Valgrind
    knows, then `verify` and an export in every format. It may find no invalid access, no branch on an unset value and
    no leak."""
    hold(shutil.which("valgrind"), "valgrind is not installed (Debian: valgrind)")
    root = bakes[0].empty_folder()
    log = os.path.join(root, "log")
    environment = bakes[0].environment()
    source, faulty = os.path.join(root, "faulty.cpp"), os.path.join(root, "faulty")
    with open(source, "w") as file:
        file.write(FAULTY)
    subprocess.run(["g++", "-O0", source, "-o", faulty], check=True)
    for fault, name in (("read", "Invalid read"), ("unset", "uninitialised"), ("leak", "definitely lost")):
        must_be_found(lambda: hold_clean([faulty, fault], environment, log), "a planted fault: " + fault)
        _, said = under_valgrind([faulty, fault], environment, log)
        hold(name in said, "%s is not reported as %s: %s" % (fault, name, said))
    devices = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"^ +levels +(.*)$", devices, re.MULTILINE)
    hold(found, "the CPU lists no levels")
    levels = [level for level in found.group(1).split(", ") if level not in UNKNOWN_LEVELS]
    runs = 0
    character = os.path.join(root, "box.glb")
    with open(character, "wb") as file:
        file.write(named_character("box"))
    # The character comes first, for the short form.
    jobs = [(scene, level) for scene in ([character], ["bar-hang-none", "--set", "bar.vertices=[4,8,4]"])
            for level in reversed(levels)]
    for scene, level in jobs[:count]:
        scene = [*scene, "--end", "0.034"]
        folder, exported = os.path.join(root, "out"), os.path.join(root, "exported")
        for command in (["inspect", *scene],
                        ["bake", *scene, "--device", "cpu:" + level, "--threads", "2", "--format", "vtu", "-o", folder],
                        ["verify", folder],
                        ["export", folder, "--to", "abc,glb,mdd,obj,pc2,usda,vtp", "-o", exported]):
            hold_clean([PROGRAM, *command], environment, log)
            runs += 1
        shutil.rmtree(folder)
        shutil.rmtree(exported)
    shutil.rmtree(root)
    return "%d runs, at the levels %s: 0 errors, 0 bytes definitely lost; a planted invalid read, a planted branch " \
           "on an unset byte and a planted leak are found" % (
               runs, ", ".join(sorted({level for _, level in jobs[:count]})))
