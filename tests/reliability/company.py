"""Bakes that share a folder or a cache, machines without a working driver, and growing loads."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time

from bakes import DONE, PROGRAM, end_by, hold, manifest, must_be_found
import large_character
from refusals import BAD_USAGE, ended, hold_refusal

NO_DEVICE = 4


IN_USE, HOLDS_A_BAKE = "another fascicle is writing there", "holds a bake"
WAYS = ((), ("--resume",), ("--overwrite",))


def ends_of(processes):
    """(exit status, stderr) of each process."""
    found = []
    for process in processes:
        _, text = process.communicate(timeout=600)
        found.append((process.returncode, text))
    return found


def hold_one_won(bake, folder, ends, reasons):
    """Exactly one bake finished. Each other one gave one of these reasons for not running, and the folder holds one
    complete bake."""
    hold(sum(status == DONE for status, _ in ends) == 1, "%s: not exactly one finished: %s" % (folder, ends))
    for status, text in ends:
        if status != DONE:
            hold_refusal(status, text, (BAD_USAGE,), reasons)
            hold(folder in text, "%s: the message does not name the folder: %s" % (folder, text))
    bake.hold_whole(folder)


def is_locked_by(process, folder):
    """Whether the process holds the lock on the folder, according to the kernel."""
    with open("/proc/locks") as file:
        lines = [line.split() for line in file]
    inode = str(os.stat(folder).st_ino)
    return any(line[1] == "FLOCK" and line[-4] == str(process.pid) and line[-3].endswith(":" + inode) for line in lines
               if "->" not in line)


def stopped_at_work(bake, folder, *more):
    """A bake that SIGSTOP has paused at a random moment while it holds its folder; None if it finished first."""
    process = bake.start(folder, *more)
    while process.poll() is None and not is_locked_by(process, folder):
        time.sleep(0.0005)
    time.sleep(random.uniform(0.0, bake.seconds / 2))
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGSTOP)
        # It may exit before it stops.
        os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
        if process.poll() is None and is_locked_by(process, folder):
            return process
    end_by(process, signal.SIGKILL)
    return None


def half_done(bake, folder):
    """Leaves a bake that was killed partway."""
    process = bake.start(folder)
    while manifest(folder) is None and process.poll() is None:
        time.sleep(0.001)
    time.sleep(random.uniform(0.0, 0.2))
    end_by(process, signal.SIGKILL)


def ends_while_stopped(bake, first, first_folder, second_folder, more):
    """The ends of a paused bake, which continues once a second one, started now, has exited; and of that second one."""
    try:
        second = bake.run(second_folder, *more)
    finally:
        os.killpg(first.pid, signal.SIGCONT)
        ends = ends_of([first])
    return [*ends, (second.returncode, second.stderr)]


def one_while_another(bake, turn):
    """Pauses a bake (from scratch, --resume or --overwrite) and runs a second one in any of these three ways. False if
    the first finished too early."""
    folder = bake.empty_folder()
    first, second = WAYS[turn % len(WAYS)], WAYS[turn // len(WAYS) % len(WAYS)]
    if first:
        half_done(bake, folder)
    process = stopped_at_work(bake, folder, *first)
    if process is not None:
        # --resume and --overwrite take the lock first. A fresh bake may instead see first that the folder is not empty.
        reasons = (IN_USE,) if second else (IN_USE, HOLDS_A_BAKE)
        hold_one_won(bake, folder, ends_while_stopped(bake, process, folder, folder, second), reasons)
    shutil.rmtree(folder)
    return process is not None


def controls_of_clashes(bake):
    """Controls: the ends of bakes without any locking."""
    folder, other = bake.empty_folder(), bake.empty_folder()
    refused = "fascicle: error: %s: %s; choose another\n" % (folder, IN_USE)
    reasons = (IN_USE,)
    process = None
    while process is None:
        shutil.rmtree(folder)
        os.mkdir(folder)
        process = stopped_at_work(bake, folder)
    # Two folders, as if the lock always succeeded.
    ends = ends_while_stopped(bake, process, folder, other, ())
    hold([status for status, _ in ends] == [DONE, DONE], "two bakes in two folders: %s" % ends)
    hold_one_won(bake, folder, [(DONE, ""), (BAD_USAGE, refused)], reasons)
    must_be_found(lambda: hold_one_won(bake, folder, ends, reasons), "two that finish")
    must_be_found(lambda: hold_one_won(bake, folder, [(BAD_USAGE, refused)] * 2, reasons), "none that finishes")
    must_be_found(lambda: hold_one_won(bake, folder, [(DONE, ""), (BAD_USAGE, refused.replace(IN_USE, "is busy"))],
                                       reasons), "a missing reason")
    os.remove(os.path.join(folder, "surface.pc2"))
    must_be_found(lambda: hold_one_won(bake, folder, [(DONE, ""), (BAD_USAGE, refused)], reasons), "a missing file")
    shutil.rmtree(folder)
    shutil.rmtree(other)


def ten_from_one_cache(built):
    folders = [built.empty_folder() for _ in range(10)]
    # Not forget_body() for each: the bakes share this cache.
    shutil.rmtree(built.cache, ignore_errors=True)
    command = lambda folder: [*built.command(folder), "--threads", "1"]
    started = [subprocess.Popen(command(folder), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                env=built.environment()) for folder in folders]
    for folder, (status, text) in zip(folders, ends_of(started)):
        hold(status == DONE, "%s: one of ten bakes with one cache exited with %d: %s" % (folder, status, text))
        built.hold_whole(folder)
        shutil.rmtree(folder)
    again = built.empty_folder()
    done = built.run(again)
    hold(done.returncode == DONE, "after ten bakes with one cache: " + done.stderr)
    built.hold_whole(again)
    shutil.rmtree(again)


def clashes(bakes, count):
    """Two bakes start at once into one folder: one wins, the other is refused. A second bake arrives while SIGSTOP
    holds a first one at a random moment, with or without `--resume` or `--overwrite`: it is refused, and the first one
    finishes. Ten bakes start at once with one empty cache."""
    controls_of_clashes(bakes[0])
    rounds = late = 0
    for k in range(count):
        bake = bakes[k % 2]
        folder = bake.empty_folder()
        one = bake.start(folder)
        time.sleep(random.uniform(0.0, 0.05))
        # The second bake finds the first one running, or its finished files.
        hold_one_won(bake, folder, ends_of([one, bake.start(folder)]), (IN_USE, HOLDS_A_BAKE))
        shutil.rmtree(folder)
        while not one_while_another(bake, k):
            late += 1
            hold(late < 20 + 10 * count, "bakes finish before they can be paused, or take no lock")
        if k % 3 == 0:
            ten_from_one_cache(bakes[2])
            rounds += 1
    return "%d pairs at once, %d with one paused: each time exactly one finished, and the other was refused with a " \
           "message; %d rounds of ten bakes with one cache; all bytes equal" % (count, count, rounds)


def lacking(root):
    """(what is missing, an environment without it, whether a Vulkan device may still be found) of each case."""
    half, program = os.path.join(root, "half.json"), os.path.join(root, "program.json")
    no_layers, half_layers = os.path.join(root, "no-layers"), os.path.join(root, "half-layers")
    os.mkdir(no_layers)
    os.mkdir(half_layers)
    for path in (half, os.path.join(half_layers, "half.json")):
        with open(path, "w") as file:
            file.write('{"file_format_version": "1.0')
    with open(program, "w") as file:
        json.dump({"file_format_version": "1.0.0", "ICD": {"library_path": "/bin/true", "api_version": "1.3.0"}}, file)
    # Older loaders know only the second name.
    of_driver = lambda path: {"VK_DRIVER_FILES": path, "VK_ICD_FILENAMES": path}
    of_layers = lambda path: {"VK_LAYER_PATH": path, "VK_INSTANCE_LAYERS": "VK_LAYER_KHRONOS_validation"}
    return (("no driver", of_driver(os.path.join(root, "none.json")), False), ("half a driver", of_driver(half), False),
            ("a driver that is a program", of_driver(program), False), ("no layer", of_layers(no_layers), True),
            ("half a layer", of_layers(half_layers), True))


def hold_layer_is_missed(environment):
    """Opening a device with the validation layer names the package that provides the layer."""
    faults = os.environ.get("FASCICLE_PLANTED_FAULTS", "")
    hold(os.path.exists(faults), "FASCICLE_PLANTED_FAULTS names no program")
    done = subprocess.run([faults, "layer"], capture_output=True, text=True, env=environment)
    hold(done.returncode == NO_DEVICE and "vulkan-validationlayers" in done.stderr,
         "without the validation layer it exits with %d: %s" % (done.returncode, done.stderr))


def drivers(bakes, count):
    """There is no Vulkan driver, or its description is half a file, or names a program in place of a library: the
    message names the package to install. Or the environment asks for the validation layer, and the layer is missing or
    its description is half a file: a bake on Vulkan gives the same bytes, or the message names the layer's package.
    Each time, `devices` lists the CPU, and the CPU bakes. A device that the program itself is to open with the
    validation layer is refused in the same way."""
    bake = bakes[0]
    root = bake.empty_folder()
    names, layers = ("mesa-vulkan-drivers",), ("vulkan-validationlayers",)
    must_be_found(lambda: hold_refusal(NO_DEVICE, "fascicle: error: no device; get one\n", (NO_DEVICE,), names),
                  "a missing package")
    must_be_found(lambda: hold_layer_is_missed(None), "a layer that is installed")
    hold_layer_is_missed({**os.environ, "VK_LAYER_PATH": bake.empty_folder()})
    cases = lacking(root)
    devices = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True).stdout
    on_vulkan = 0
    for k in range(count):
        what, changes, may_be_left = cases[k % len(cases)]
        environment = bake.environment(**changes)
        folder = os.path.join(root, "out")
        status, text = ended(bake.command(folder, "--device", "vulkan"), environment, root)
        if status == DONE and may_be_left:
            hold("vulkan:0" in devices, "baked on a device that does not exist: " + text)
            bake.hold_whole(folder)
            shutil.rmtree(folder)
            on_vulkan += 1
        else:
            hold_refusal(status, text, (NO_DEVICE,), layers if may_be_left else names)
        hold(not os.path.exists(folder) or not os.listdir(folder), "%s, %s: something was written" % (folder, what))
        status, text = ended([PROGRAM, "devices"], environment, root)
        hold(status == DONE and "cpu" in text, "%s: `devices` exited with %d: %s" % (what, status, text))
        status, text = ended(bake.command(folder, "--device", "auto" if not may_be_left else "cpu"), environment, root)
        hold(status == DONE, "%s: the CPU does not bake: %s" % (what, text))
        bake.hold_whole(folder)
        shutil.rmtree(folder)
    shutil.rmtree(root)
    return "%d runs: %d messages name the package; %d bakes without the layer have the same bytes, and so has every " \
           "bake on the CPU" % (count, count - on_vulkan, on_vulkan)


def figures_of(command, environment):
    """(Peak memory in bytes, CPU time in seconds, bytes written) of a program and its children."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment)
    text = process.stderr.read()
    # After it exits but before it is reaped, so that the count includes its threads and children.
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    with open("/proc/%d/io" % process.pid) as file:
        written = next(int(line.split()[1]) for line in file if line.startswith("wchar:"))
    _, status, usage = os.wait4(process.pid, 0)
    process.stderr.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    hold(process.returncode == DONE, "%s exited with %d: %s" % (" ".join(command), process.returncode, text))
    return usage.ru_maxrss * 1024, usage.ru_utime + usage.ru_stime, written


def memory_of(command, environment):
    """The first two figures of figures_of()."""
    return figures_of(command, environment)[:2]


def hold_written(few_bytes, few, many_bytes, many):
    """With ten times the pieces, each may write a fifth more: checkpoints list what is done, and their number depends
    on time."""
    hold(many_bytes / many <= 1.2 * few_bytes / few, "each piece writes more: %.0f bytes with %d pieces, %.0f with %d"
         % (few_bytes / few, few, many_bytes / many, many))


def hold_flat(few, many):
    """Ten times the work may take a tenth more memory, plus a table of position hashes."""
    hold(many <= 1.1 * few + (4 << 20), "memory grows with the work: from %d MiB to %d MiB" % (few >> 20, many >> 20))


def hold_same(one, other, what):
    hold(one and one == other, "position hashes differ: " + what)


def load(bakes, count):
    """One bake has very many frames, a batch has a tenth as many jobs of two frames each, and a character of 300 joints
    has a hundredth as many clips. A bar has 200 vertices for each of those frames: 2 million. Each runs beside one of a
    tenth of its size. Memory may grow by a tenth, or with the bar; a frame, job, clip or vertex may take twice the CPU
    time, because caches are small, and a frame may write a fifth more bytes; a part that is baked alone has the same
    position hashes."""
    must_be_found(lambda: hold_flat(100 << 20, 200 << 20), "growing memory")
    must_be_found(lambda: hold_pace(1.0, 10, 21.0, 100), "a slowing pace")
    must_be_found(lambda: hold_same(["1"], ["2"], "a control"), "different hashes")
    controls_of_written(bakes[0].environment())
    root = bakes[0].empty_folder()
    environment = bakes[0].environment(FASCICLE_CACHE_DIR=os.path.join(root, "cache"))
    said = [part(root, environment, count) for part in (load_of_frames, load_of_jobs, load_of_clips, load_of_vertices)]
    shutil.rmtree(root)
    return ". ".join(said)


def controls_of_written(environment):
    """Controls: a child writes frames of 1500 bytes and a list of finished frames, either never or anew every 100
    frames."""
    script = "import subprocess, sys; subprocess.run([sys.executable, '-c', sys.argv[1]], stdout=subprocess.DEVNULL)"
    child = "import os; [os.write(1, b'0' * (1500 + (30 * i if i %% 100 == 0 and %d else 0))) for i in range(%d)]"
    written = lambda *how: figures_of([sys.executable, "-S", "-c", script, child % how], environment)[2]
    figures = {(again, frames): written(again, frames) for again in (0, 1) for frames in (1000, 10000)}
    hold(figures[0, 10000] >= 15000000, "the bytes that a child writes are not counted")
    hold_written(figures[0, 1000], 1000, figures[0, 10000], 10000)
    must_be_found(lambda: hold_written(figures[1, 1000], 1000, figures[1, 10000], 10000), "a list that is rewritten")


def hold_pace(few_seconds, few, many_seconds, many):
    """With ten times the pieces, each may take twice the CPU time, because caches are small and shared. Calls of less
    than half a second are too short to compare."""
    hold(many_seconds / many <= 2 * max(few_seconds, 0.5) / few,
         "it slows down: %.3f s each of %d, then %.3f s of %d" % (few_seconds / few, few, many_seconds / many, many))


SMALL = ("bar.vertices=[4,8,4]",)


def load_of_frames(root, environment, count):
    found, hashes = [], []
    for frames in (count // 10, count):
        folder = os.path.join(root, "frames")
        sets = [word for one in SMALL for word in ("--set", one)]
        found.append(figures_of([PROGRAM, "bake", "bar-hang-none", *sets, "--device", "cpu", "--threads", "1",
                                 "--overwrite", "--end", repr(frames / 60), "-o", folder], environment))
        hashes.append(manifest(folder)["position_hashes"])
        hold(len(hashes[-1]) == frames + 1, folder + ": frames are missing")
    hold_flat(found[0][0], found[1][0])
    hold_pace(found[0][1], count // 10, found[1][1], count)
    hold_written(found[0][2], count // 10, found[1][2], count)
    hold_same(hashes[0], hashes[1][:len(hashes[0])], "of the first frames of a longer bake")
    return "%d frames used %d MiB and %d used %d; each frame took %.1f times as long and wrote %.2f times as much" % (
        count, found[1][0] >> 20, count // 10, found[0][0] >> 20, found[1][1] / found[0][1] / 10,
        found[1][2] / found[0][2] / 10)


def load_of_jobs(root, environment, count):
    jobs = os.path.join(root, "jobs.toml")
    many = []
    for number in (max(1, count // 100), max(10, count // 10)):
        values = ["%.6f" % (0.1 + 0.8 * k / number) for k in range(number)]
        with open(jobs, "w") as file:
            file.write('format = ["pc2"]\n[job.bar]\nscene = "bar-hang-none"\n'
                       'set = ["scene.end=0.0334", "%s"]\n'
                       '[job.bar.vary]\n"layers.body.alpha" = [%s]\n' % (SMALL[0], ", ".join(values)))
        folder = os.path.join(root, "batch")
        many.append((number, *memory_of([PROGRAM, "batch", jobs, "--device", "cpu", "-o", folder], environment)))
        with open(os.path.join(folder, "batch.json")) as file:
            said = json.dumps(json.load(file))
        hold(said.count('"done"') >= number, folder + ": jobs are missing")
        one = os.path.join(root, "one")
        memory_of([PROGRAM, "bake", "bar-hang-none", "--end", "0.0334", "--set", SMALL[0], "--set",
                   "layers.body.alpha=" + values[-1], "--device", "cpu", "--overwrite", "-o", one], environment)
        of_jobs = [manifest(os.path.join(folder, name))["position_hashes"] for name in os.listdir(folder)
                   if os.path.isdir(os.path.join(folder, name)) and not name.startswith(".")]
        hold(len(of_jobs) == number, folder + ": %d folders" % len(of_jobs))
        hold(manifest(one)["position_hashes"] in of_jobs, "a job baked alone has different position hashes")
        shutil.rmtree(folder)
    hold_flat(many[0][1], many[1][1])
    hold_pace(many[0][2], many[0][0], many[1][2], many[1][0])
    return "%d jobs used %d MiB and %d used %d; each took %.1f times as long" % (
        many[1][0], many[1][1] >> 20, many[0][0], many[0][1] >> 20,
        many[1][2] / many[0][2] * many[0][0] / many[1][0])


def load_of_clips(root, environment, count):
    joints, found = 300, []
    for clips in (max(1, count // 1000), max(2, count // 100)):
        path = os.path.join(root, "snake.gltf")
        large_character.write(path, joints, clips)
        folder = os.path.join(root, "clips")
        common = ["--cage", "off", "--device", "cpu", "--threads", "1"]
        memory_of([PROGRAM, "inspect", path, "--cage", "off"], environment)  # caches the body
        found.append((clips, *memory_of([PROGRAM, "bake", path, "--clips", "all", *common, "-o", folder], environment)))
        baked = [manifest(os.path.join(folder, name))["position_hashes"] for name in sorted(os.listdir(folder))
                 if os.path.exists(os.path.join(folder, name, "manifest.json"))]
        hold(len(baked) == clips, folder + ": %d of %d clips baked" % (len(baked), clips))
        hold(clips == 1 or len(set(map(str, baked))) == clips, folder + ": two clips have the same hashes")
        one = os.path.join(root, "one-clip")
        memory_of([PROGRAM, "bake", path, "--clip", "clip %d" % (clips - 1), *common, "--overwrite", "-o", one],
                  environment)
        hold(manifest(one)["position_hashes"] in baked, "a clip baked alone has different position hashes")
        shutil.rmtree(folder)
    hold_flat(found[0][1], found[1][1])
    hold_pace(found[0][2], found[0][0], found[1][2], found[1][0])
    return "%d clips of %d joints used %d MiB and %d used %d; each took %.1f times as long" % (
        found[1][0], joints, found[1][1] >> 20, found[0][0], found[0][1] >> 20,
        found[1][2] / found[0][2] * found[0][0] / found[1][0])


def load_of_vertices(root, environment, count):
    found = []
    for wanted in (20 * count, 200 * count):
        side = max(4, round((wanted / 2) ** (1 / 3)))
        vertices = (2 * side, side, side)
        folder, hashes = os.path.join(root, "large"), []
        for threads in ("2", "1"):
            figures = memory_of([PROGRAM, "bake", "bar-hang-none", "--set", "bar.vertices=[%d,%d,%d]" % vertices,
                                 "--set", "solver.substeps=5", "--end", "0.0334", "--device", "cpu", "--threads",
                                 threads, "--overwrite", "-o", folder], environment)
            hashes.append(manifest(folder)["position_hashes"])
        hold_same(hashes[0], hashes[1], "with another number of threads")
        found.append((2 * side ** 3, *figures))
        shutil.rmtree(folder)
    least, most = found
    # The difference cancels the fixed memory of the program.
    hold((most[1] - least[1]) / (most[0] - least[0]) < 4096, "%d MiB for %d vertices" % (most[1] >> 20, most[0]))
    hold_pace(least[2], least[0], most[2], most[0])
    return "%d vertices used %d MiB and %d used %d; each took %.1f times as long" % (
        most[0], most[1] >> 20, least[0], least[1] >> 20, most[2] / least[2] * least[0] / most[0])
