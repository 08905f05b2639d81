"""The files, sockets and programs that bakes use."""

import glob
import os
import re
import shutil
import subprocess
import sys

from bakes import DONE, PROGRAM, hold, must_be_found
import collada
import large_character

PROGRAMS = ("fascicle", "fascicle-mesher")
CONVERTER = "fascicle-convert"
# All calls that name a file or use a socket. LOOKS are calls that only query a file.
CALLS = "trace=%file,socket,connect,bind"
LOOKS = re.compile(r"(new|old)?l?f?stat(at|64|x|fs|fs64)?$|statx$|access$|faccessat2?$|readlink(at)?$|getcwd$|chdir$")
CHANGES = re.compile(r"O_WRONLY|O_RDWR|O_CREAT|O_TRUNC")

# Paths, and all below them, that a bake may open for reading besides its input, output, cache and temporary folder; and
# why.
READ_BY_ALL = (
    (os.path.dirname(PROGRAM), "the program, the mesher beside it"),
    ("/etc/ld.so.cache", "where the loader finds libraries"),
    ("/etc/ld.so.preload", "the loader looks for it"),
    ("/lib", "libraries"), ("/lib64", "libraries"), ("/usr/lib", "libraries"),
    ("/proc/self", "where the program lies, how much memory it and its children have"),
    ("/proc/meminfo", "how many bakes of a batch there is memory for"),
    ("/sys/fs/cgroup", "the same in a container"),
    ("/proc/cpuinfo", "the processor's name, for the manifest"),
    ("/sys/devices/system/cpu", "how many cores there are"),
    ("/proc/sys/vm/overcommit_memory", "the C library, as it gives memory back"),
    ("/dev/null", "in place of a child's input"),
)
# Paths that the Vulkan loader and Mesa also open on lavapipe.
READ_BY_VULKAN = (
    ("/usr/share/vulkan", "the loader: drivers, layers"), ("/usr/local/share/vulkan", "the loader"),
    ("/etc/vulkan", "the loader"), ("/etc/xdg/vulkan", "the loader"),
    ("HOME/.config/vulkan", "the loader"), ("HOME/.local/share/vulkan", "the loader"),
    ("/usr/share/drirc.d", "Mesa's options"), ("/etc/drirc", "Mesa's options"), ("HOME/.drirc", "Mesa's options"),
    ("/dev/dri", "Mesa: GPUs"), ("/sys/class/drm", "Mesa: GPUs"), ("/sys/dev/char", "Mesa: GPUs"),
)


def traced(command, environment, folder, log):
    """The traced calls of a command and its children, one line each, including failed ones."""
    shutil.rmtree(log, ignore_errors=True)
    os.mkdir(log)
    # -y prints the folder that a relative path belongs to.
    done = subprocess.run(["strace", "-ff", "-y", "-qq", "-s", "4096", "-e", CALLS, "-o", log + "/of", *command],
                          capture_output=True, text=True, env=environment, cwd=folder)
    hold(done.returncode == DONE, "%s: %s" % (" ".join(command), done.stderr))
    lines = []
    for name in os.listdir(log):
        with open(os.path.join(log, name), errors="replace") as file:
            lines += [line for line in file.read().splitlines() if not line.startswith(("---", "+++"))]
    return lines


def of_own(path):
    """/proc/PID is a traced process, so treat it as /proc/self."""
    return re.sub(r"^/proc/\d+", "/proc/self", path)


def is_below(path, folders):
    return any(path == folder or path.startswith(folder.rstrip("/") + "/") for folder in folders)


def hold_inside(lines, allowed, read=(), programs=PROGRAMS):
    """Changes are only below `allowed`, reads only there or below `read`, only `programs` are started, and no socket is
    used. Failed calls count too."""
    for line in lines:
        name, _, words = line.partition("(")
        paths = [of_own(os.path.normpath(os.path.join(folder, path))) for folder, path in
                 re.findall(r'(?:(?:AT_FDCWD|\d+)<([^>]*)>, )?"((?:[^"\\]|\\.)*)"', words)]
        if name in ("socket", "connect", "bind"):
            hold(False, "a socket: " + line)
        elif name == "execve":
            # A batch starts this program again for its bakes.
            hold(os.path.basename(paths[0]) in programs or paths[0] == "/proc/self/exe", "another program: " + line)
        elif not LOOKS.match(name):
            is_change = not name.startswith("open") or CHANGES.search(line)
            for path in paths:
                hold(is_below(path, allowed) or path in ("/dev/null", "/dev/tty") or
                     not is_change and is_below(path, read), "an unexpected file: " + line)


def hold_controls(bake):
    """Controls: programs that break each rule."""
    root = bake.empty_folder()
    python = os.path.basename(sys.executable)
    passwd = "open('/etc/passwd').read()"
    for script, what in (("import socket; socket.socket()", "a socket"),
                         ("import os; os.execv('/bin/true', ['true'])", "another program"),
                         (passwd, "a file that is read"),
                         ("import os; os.path.exists('/etc/no-such') or open('/etc/no-such', 'a+', opener=lambda p, f: "
                          "os.open(p, os.O_RDONLY))", "a file that is looked for"),
                         ("open(%r, 'w').close()" % os.path.join(root, "sibling-x"), "a file of a folder beside")):
        script = "try:\n %s\nexcept OSError: pass" % script
        lines = traced([sys.executable, "-S", "-c", script], bake.environment(), root, root + "/control")
        # Python itself reads files all over the system.
        read = [path for path in ("/usr", "/lib", "/lib64", "/proc", "/sys", "/root", "/home", "/opt", sys.prefix,
                                  sys.base_prefix, "/etc/localtime", "/etc/ld.so.cache", "/etc/ld.so.preload")]
        programs = (python, "python3")
        if script.find(passwd) >= 0:
            hold_inside(lines, (os.path.join(root, "sibling"),), (*read, "/etc/passwd"), programs)
        must_be_found(lambda: hold_inside(lines, (os.path.join(root, "sibling"),), read, programs), what)
    shutil.rmtree(root)


def outside(bakes, count):
    """strace shows what the program asks of the system: sockets, files that it changes, opens or fails to open, and
    programs that it starts. Only asking whether a file exists, or for its size, is not held against it. It watches
    bakes of a bar, of generated characters and of characters from a glTF and a Collada file, an export, a batch, and a
    bake on Mesa's software Vulkan device."""
    hold_controls(bakes[0])
    drivers = glob.glob("/usr/share/vulkan/icd.d/lvp_icd*.json")
    has_converter = os.path.exists(os.path.join(os.path.dirname(PROGRAM), CONVERTER))

    def prepared(root):
        """Writes the input files of the commands below."""
        large_character.write(os.path.join(root, "snake.gltf"), 6, 1)
        collada.write(os.path.join(root, "spindle.dae"))
        with open(os.path.join(root, "jobs.toml"), "w") as file:
            file.write('[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=0.1"]\nformat = ["pc2"]\n'
                       '[job.snake]\nscene = "snake.gltf"\n')

    def read_by_vulkan(environment):
        return tuple((path.replace("HOME", environment["HOME"]), why) for path, why in READ_BY_VULKAN)

    def traced_bake(bake, root, environment):
        return traced(bake.command(os.path.join(root, "out")), environment, root, root + ".strace"), ()

    def of_file(bake, root, environment):
        command = [PROGRAM, "bake", "snake.gltf", "--device", "cpu", "--format", "glb,usda"]
        return traced([*command, "-o", root + "/out"], environment, root, root + ".strace"), ()

    def converted(bake, root, environment):
        if not has_converter:
            return None, ()
        command = [PROGRAM, "bake", "spindle.dae", "--end", "0.05", "--device", "cpu", "-o", root + "/out"]
        lines = traced(command, environment, root, root + ".strace")
        hold(any(CONVERTER in line for line in lines if line.startswith("execve(")), "the converter was not started")
        return lines, ()

    def of_export(bake, root, environment):
        command = [PROGRAM, "export", bake.folder_of_whole, "--to", "abc,mdd,obj,pc2,usda,vtp"]
        lines = traced([*command, "-o", root + "/out"], environment, root, root + ".strace")
        return lines, ((bake.folder_of_whole, "the bake"),)

    def of_batch(bake, root, environment):
        command = [PROGRAM, "batch", "jobs.toml", "--device", "cpu", "-o", root + "/out"]
        return traced(command, environment, root, root + ".strace"), ()

    def on_vulkan(bake, root, environment):
        if not drivers:
            return None, ()
        command = [PROGRAM, "bake", "bar-hang-none", "--end", "0.1", "--device", "vulkan", "-o", root + "/out"]
        lines = traced(command, environment, root, root + ".strace")
        return lines, read_by_vulkan(environment)

    kinds = ((traced_bake, bakes[2]), (on_vulkan, bakes[0]), (of_file, bakes[0]), (of_batch, bakes[0]),
             (converted, bakes[0]), (of_export, bakes[1]), (traced_bake, bakes[0]), (traced_bake, bakes[1]))
    traces = 0
    for k in range(count):
        trace, bake = kinds[k % len(kinds)]
        bake.forget_body()
        root = bake.empty_folder()
        temporary, home = bake.empty_folder(), bake.empty_folder()
        prepared(root)
        environment = bake.environment(TMPDIR=temporary, HOME=home, XDG_CACHE_HOME=os.path.join(home, "cache"))
        if drivers:
            environment.update(VK_DRIVER_FILES=drivers[0], VK_ICD_FILENAMES=drivers[0])
        lines, more = trace(bake, root, environment)
        if lines is None:
            continue
        hold(len(lines) > 20, "strace saw nothing")
        read = [path for path, _ in (*READ_BY_ALL, *more)] + [root]
        out = os.path.join(root, "out")
        allowed = [out, bake.cache, temporary]
        programs = (*PROGRAMS, CONVERTER) if trace is converted else PROGRAMS
        hold_inside(lines, allowed, read, programs)
        if trace is converted:
            must_be_found(lambda: hold_inside(lines, allowed, read), "a program that this bake alone may start")
        must_be_found(lambda: hold_inside(lines, allowed[1:], read, programs), "files outside the allowed folders")
        without = [path for path in read if "lib" not in path]
        must_be_found(lambda: hold_inside(lines, allowed, without, programs),
                      "libraries that are read without permission")
        kept = os.listdir(home)
        hold(not kept, "files in the home folder: " + ", ".join(kept))
        traces += 1
        for folder in (root, temporary, home, root + ".strace"):
            shutil.rmtree(folder)
    said = "on the CPU and on lavapipe" if drivers else "on the CPU (NOT TESTED: lavapipe, which is not here)"
    if not has_converter:
        said += " (NOT TESTED: the converter, which was not built)"
    return "%d traces: no socket; nothing changed but the output, the cache and temporary files; nothing else " \
           "opened or looked for by opening it but the input, libraries and the system's description of the " \
           "processor; no program started but the mesher, the converter for Collada and, by a batch, its bakes; %s" % (
               traces, said)
