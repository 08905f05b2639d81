"""What a bake asks of the system."""

import os
import re
import shutil
import subprocess
import sys

from bakes import DONE, hold, must_be_found


def outside(bakes, count):
    """What a bake asks of the system, by strace: sockets, files it changes, programs it starts."""
    calls = "trace=socket,connect,bind,open,openat,creat,unlink,unlinkat,rename,renameat,renameat2,mkdir,mkdirat," \
            "link,linkat,symlink,symlinkat,truncate,execve"

    def traced(command, environment, log):
        """The calls of it and of its children, whole lines each."""
        shutil.rmtree(log, ignore_errors=True)
        os.mkdir(log)
        # -y names the folders of names that are relative to one.
        done = subprocess.run(["strace", "-ff", "-y", "-qq", "-s", "4096", "-e", calls, "-o", log + "/of", *command],
                              capture_output=True, text=True, env=environment)
        hold(done.returncode == DONE, done.stderr)
        lines = []
        for name in os.listdir(log):
            with open(os.path.join(log, name), errors="replace") as file:
                lines += [line for line in file.read().splitlines() if " = -1" not in line]
        return lines

    def hold_inside(lines, allowed, programs):
        for line in lines:
            name = line.partition("(")[0]
            paths = [os.path.join(folder, path)
                     for folder, path in re.findall(r'(?:(?:AT_FDCWD|\d+)<([^>]*)>, )?"([^"]*)"', line)]
            hold(name not in ("socket", "connect", "bind"), "a socket: " + line)
            if name == "execve":
                hold(os.path.basename(paths[0]) in programs, "another program: " + line)
            elif not name.startswith("open") or re.search(r"O_WRONLY|O_RDWR|O_CREAT|O_TRUNC", line):
                for path in paths:
                    hold(path in ("/dev/null", "/dev/tty") or
                         any((path + "/").startswith(folder + "/") for folder in allowed), "a file outside: " + line)

    programs = ("fascicle", "fascicle-mesher")
    for k in range(count):
        bake = bakes[k % len(bakes)]
        folder = bake.empty_folder()
        bake.forget_body()
        temporary = bake.empty_folder()
        lines = traced(bake.command(folder, "--overwrite"), bake.environment(TMPDIR=temporary), folder + ".strace")
        hold(len(lines) > 20, "strace saw nothing")
        hold_inside(lines, (folder, bake.cache, temporary), programs)
        must_be_found(lambda: hold_inside(lines, (bake.cache, temporary), programs), "files outside")
        shutil.rmtree(folder)
    control, python = bakes[0].root + "/control", os.path.basename(sys.executable)
    for script, what in (("import socket; socket.socket()", "a socket"),
                         ("import os; os.execv('/bin/true', ['true'])", "another program")):
        lines = traced([sys.executable, "-c", script], bakes[0].environment(), control)
        must_be_found(lambda: hold_inside(lines, ("/",), (python, "python3")), what)
    return "%d bakes: no socket, no file outside the bake's folder, the cache and what is temporary, no program but " \
           "the mesher" % count
