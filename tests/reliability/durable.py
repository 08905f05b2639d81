"""What survives a power cut: strace records the order in which commands write, sync and rename files."""

import os
import re
import shutil
import subprocess

from bakes import DONE, GROWING, PROGRAM, UNFINISHED, Broken, hold, must_be_found
from killed import EVERY_FORMAT

CALLS = ("openat,creat,open,write,pwrite64,writev,pwritev,pwritev2,ftruncate,truncate,copy_file_range,sendfile,fsync,"
         "fdatasync,rename,renameat,renameat2,link,linkat,mkdir,mkdirat,unlink,unlinkat,rmdir")
WRITES = ("write", "pwrite64", "writev", "pwritev", "pwritev2", "ftruncate", "truncate", "copy_file_range", "sendfile")

# (pattern of paths, why they need not survive a power cut).
NOT_DURABLE = (
    (r"/fascicle-helper-\w+(/|$)", "messages between the program and the mesher, which neither keeps"),
    (r"/surface\.(abc|glb|usda)(\.\w+)?\.part$", "streams that a resumed bake starts over, until their last rename"),
    (r"/export\.part(/|$)", "the folder in which an export is made, until its files are moved up"),
    (r"/cache$", "the cache folder itself, which is made again when it is lost"),
)


class Call:
    """A successful call; `begin` and `end` index the lines of the log, across all threads."""

    def __init__(self, name, paths, line, begin, end):
        self.name, self.paths, self.line, self.begin, self.end = name, paths, line, begin, end


def calls_of(log):
    """Successful calls by the order in which they returned: until a call returns it guarantees nothing."""
    found, unfinished = [], {}
    for number, line in enumerate(log):
        process, _, rest = line.partition(" ")
        rest = rest.strip()
        begin = number
        if rest.endswith("<unfinished ...>"):
            unfinished[process] = rest[:-len("<unfinished ...>")], number
            continue
        if rest.startswith("<... "):
            if process not in unfinished:
                continue
            before, begin = unfinished.pop(process)
            rest = before + rest.partition("resumed>")[2]
        called = re.match(r"(\w+)\((.*)\)\s+= (-?\d+)", rest)
        if not called or called.group(3).startswith("-"):
            continue
        name, arguments = called.group(1, 2)
        if name in WRITES + ("fsync", "fdatasync") and name != "truncate":
            # copy_file_range writes to its second descriptor.
            descriptors = re.findall(r"\d+<([^>]*)>", arguments)
            paths = [descriptors[-1 if name == "copy_file_range" else 0]] if descriptors else []
        else:
            paths = [os.path.join(folder, path)
                     for folder, path in re.findall(r'(?:(?:AT_FDCWD|\d+)<([^>]*)>, )?"([^"]*)"', arguments)]
        if paths:
            found.append(Call(name, [os.path.normpath(path) for path in paths], rest, begin, number))
    return found


def is_final(path, root):
    return path.startswith(root + "/") and not any(part.endswith(UNFINISHED) for part in path[len(root):].split("/"))


def need_not_last(path):
    return any(re.search(pattern, path) for pattern, _ in NOT_DURABLE)


class File:
    def __init__(self):
        self.written = -1  # when its last write returned
        self.synced = -1   # when its last completed sync began

    def is_safe(self):
        return self.synced > self.written


class Disk:
    """The state of the files below `root`, as the order of calls implies it."""

    def __init__(self, root):
        self.root = root
        self.files, self.named, self.held = {}, {}, set()

    def file(self, path):
        return self.files.setdefault(path, File())

    def apply(self, call):
        path = call.paths[0]
        if call.name in WRITES:
            self.file(path).written = call.end
        elif call.name in ("fsync", "fdatasync"):
            self.file(path).synced = call.begin
            self.named = {name: at for name, at in self.named.items()
                          if os.path.dirname(name) != path or at > call.begin}
        elif call.name in ("openat", "open", "creat") and re.search(r"O_CREAT|O_TRUNC|creat\(", call.line):
            self.files[path] = File()
            self.files[path].written = call.end
            if is_final(path, self.root) and not need_not_last(path):
                hold(os.path.basename(path) == GROWING, "created under its final name: " + call.line)
                self.named[path] = call.end
        elif call.name.startswith("mkdir"):
            if is_final(path, self.root) and not need_not_last(path):
                self.named[path] = call.end
        elif call.name.startswith(("unlink", "rmdir")):
            self.files.pop(path, None)
            self.named.pop(path, None)
        elif call.name.startswith(("rename", "link")):
            self.rename(call, path, call.paths[1])

    def rename(self, call, old, new):
        if new.endswith("/checkpoint"):
            self.hold_counted(os.path.dirname(new), call)
        moved = self.files.pop(old, None)
        if moved is None:  # a file of an earlier command
            moved = File()
            moved.synced = 0
        self.files[new] = moved
        if is_final(new, self.root) and not need_not_last(new):
            hold(moved.is_safe(), "renamed before its bytes were synced: " + call.line)
            self.named[new] = call.end
            self.held.add(new)

    def hold_counted(self, folder, call):
        """Everything in a bake's folder is synced before a checkpoint relies on it."""
        for path, file in self.files.items():
            if path.startswith(folder + "/") and not need_not_last(path):
                hold(file.is_safe(), "%s: not synced before the checkpoint that relies on it: %s" % (path, call.line))
        late = [name for name in self.named if name.startswith(folder + "/")
                and name not in (os.path.join(folder, "checkpoint"), os.path.join(folder, "manifest.json"))]
        hold(not late, "%s: folder not synced before the checkpoint that relies on it" % ", ".join(late))

    def hold_end(self):
        hold(not self.named, "the folder is not synced after naming: " + ", ".join(self.named))
        for path, file in self.files.items():
            hold(not is_final(path, self.root) or need_not_last(path) or file.is_safe(),
                 path + ": not synced at the end")


def hold_durable(log, root):
    """Checks that every file was synced before its final rename and its folder after it; returns the number of renamed
    files."""
    disk = Disk(root)
    for call in calls_of(log):
        if any(path.startswith(root + "/") or path == root for path in call.paths):
            disk.apply(call)
    disk.hold_end()
    return len(disk.held)


def traced(command, environment, root):
    log = root + ".strace"
    done = subprocess.run(["strace", "-f", "-y", "-qq", "-s", "1", "-e", "trace=" + CALLS, "-o", log, *command],
                          capture_output=True, text=True, env=environment, cwd=root)
    hold(done.returncode == DONE, "%s exited with %d: %s" % (" ".join(command), done.returncode, done.stderr))
    with open(log, errors="replace") as file:
        return file.read().splitlines()


def control_of_order(log, root):
    """Controls: the same calls with a sync removed or in the wrong order."""
    def without(pattern):
        left = [line for line in log if not (re.search(r" (fsync|fdatasync)\(|<\.\.\. (fsync|fdatasync) ", line) and
                                             re.search(pattern, line))]
        hold(len(left) < len(log), "the control removed nothing: " + pattern)
        return left

    must_be_found(lambda: hold_durable(without(""), root), "no sync at all")
    bake = re.escape(os.path.join(root, "bake"))
    for name in ("", "/obj", "/vtu", "/frames.fascicle", "/metrics.csv.part", "/surface.pc2.part", "/surface.glb.part",
                 "/checkpoint.tmp", "/manifest.json.tmp", "/model.fascicle.tmp", r"/obj/frame_000003.obj.tmp"):
        must_be_found(lambda: hold_durable(without("<%s%s>" % (bake, name)), root), "no sync of bake" + name)
    at = next(k for k, line in enumerate(log) if 'model.fascicle.tmp", ' in line and "rename(" in line)
    sync = max(k for k in range(at) if "fsync(" in log[k] and "model.fascicle.tmp>" in log[k])
    swapped = [*log[:sync], log[at], *log[sync:at], *log[at + 1:]]
    must_be_found(lambda: hold_durable(swapped, root), "a rename before the sync")


def durable(bakes, count):
    """strace records the commands that write files: a bake in all formats with a cache, the same bake resumed to a
    later end, exports into the bake and beside it, a batch, its forms for farms, a batch in parts and their merging,
    pictures, a report, a page to view, a validation, a benchmark and the model of `inspect`. The bytes of a file are
    synced before it gets its final name, and its folder is synced after that. Everything that a checkpoint relies on is
    synced before the checkpoint."""
    why_not = subprocess.run(["strace", "-o", "/dev/null", "true"], capture_output=True).returncode \
        if shutil.which("strace") else 1
    if why_not:
        return "NOT TESTED: no strace, or no process may be traced here"
    root = bakes[1].empty_folder()
    jobs = os.path.join(root, "jobs.toml")
    with open(jobs, "w") as file:
        file.write('format = ["pc2", "obj"]\n[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=0.3"]\n'
                   '[job.bar.vary]\n"layers.body.alpha" = [0.3, 0.6]\n')
    environment = {**os.environ, "FASCICLE_CACHE_DIR": os.path.join(root, "cache"), "TMPDIR": root}
    bake, device = os.path.join(root, "bake"), ("--device", "cpu")
    character = list(bakes[1].arguments)
    longer = list(character)
    character[character.index("--end") + 1] = "0.1"
    longer[longer.index("--end") + 1] = "0.15"
    commands = {
        "bake": ["bake", *character, *device, "-o", bake],
        "resume": ["bake", *longer, *device, "-o", bake, "--resume"],
        "export": ["export", bake, "--to", EVERY_FORMAT, "-o", os.path.join(root, "export")],
        "own export": ["export", bake, "--to", EVERY_FORMAT, "--overwrite"],
        "batch": ["batch", jobs, *device, "-o", os.path.join(root, "batch")],
        "render": ["render", bake, "--size", "160x120", "-o", os.path.join(root, "pictures")],
        "picture": ["render", bake, "--size", "160x120", "-o", os.path.join(root, "picture.png")],
        "report": ["report", bake, "-o", os.path.join(root, "report.html")],
        "view": ["view", bake, "-o", os.path.join(root, "view.html")],
        "emit": ["batch", jobs, "--emit", "slurm", "-o", os.path.join(root, "farm")],
        "template": ["batch", jobs, "--emit", "openjd", "-o", os.path.join(root, "farm.json")],
        "job": ["batch", jobs, "--job", "1-2", *device, "-o", os.path.join(root, "parts")],
        "merge": ["batch", "status", jobs, "-o", os.path.join(root, "parts"), "--merge"],
        "model": ["inspect", "bar-hang-none", "--model", os.path.join(root, "model.vtu")],
        "validate": ["validate", "bar-beta-1", "--devices", "cpu", "--frames", "2", "--html",
                     os.path.join(root, "validate.html")],
        "bench": ["bench", "--vertices", "300", "--rounds", "1", "--threads", "1", "--integrator", "explicit",
                  "--no-peers", "--json", os.path.join(root, "bench.json"), "--csv", os.path.join(root, "bench.csv")],
    }
    held = dict.fromkeys(commands, 0)
    for k in range(count):
        name = list(commands)[k % len(commands)]
        if k and k % len(commands) == 0:
            for of in os.listdir(root):
                shutil.rmtree(os.path.join(root, of)) if os.path.isdir(os.path.join(root, of)) else None
        log = traced([PROGRAM, *commands[name], *(["--overwrite"] if k >= len(commands) and name in (
            "picture", "report", "view") else [])], environment, root)
        try:
            held[name] += hold_durable(log, root)
        except Broken as error:
            raise Broken("%s: %s" % (name, error)) from error
        hold(held[name], name + ": no file was renamed into place")
        if k == 0:
            control_of_order(log, root)
    shutil.rmtree(root)
    os.remove(root + ".strace")
    text = "%d runs, %d files: every file was synced before it got its name, and its folder after (%s); exempt: %s"
    return text % (
        count, sum(held.values()), ", ".join("%s %d" % pair for pair in held.items()),
        "; ".join(reason for _, reason in NOT_DURABLE))
