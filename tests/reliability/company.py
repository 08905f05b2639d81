"""Bakes that share what they should not, machines without a driver, and loads that grow."""

import json
import os
import random
import shutil
import signal
import subprocess
import time

from bakes import DONE, PROGRAM, end_by, hold, manifest, must_be_found
from refusals import ended, hold_refusal

NO_DEVICE = 4


def ends_of(processes):
    """(status, what it says) of each, however long it takes."""
    found = []
    for process in processes:
        _, text = process.communicate(timeout=600)
        found.append((process.returncode, text))
    return found


def hold_one_won(bake, folder, ends):
    """At least one came to its end, each other one says why it did not, and the folder holds one whole bake."""
    hold(any(status == DONE for status, _ in ends), "%s: none came to its end: %s" % (folder, ends))
    for status, text in ends:
        if status != DONE:
            hold_refusal(status, text, (1, 2, 3), (os.path.basename(folder),))
    bake.hold_whole(folder)


def clashes(bakes, count):
    """Two bakes at once into one folder; two that resume one bake; ten from one empty cache."""
    first, _, built = bakes
    folder = first.empty_folder()
    shutil.copytree(first.folder_of_whole, folder, dirs_exist_ok=True)
    refused = "fascicle: error: %s: is busy\n" % folder
    hold_one_won(first, folder, [(DONE, ""), (2, refused)])
    must_be_found(lambda: hold_one_won(first, folder, [(2, refused), (2, refused)]), "none at its end")
    os.remove(os.path.join(folder, "surface.pc2"))
    must_be_found(lambda: hold_one_won(first, folder, [(DONE, ""), (2, refused)]), "a file that lacks")
    shutil.rmtree(folder)
    turned_away = 0
    for k in range(count):
        bake = bakes[k % 2]
        folder = bake.empty_folder()
        if k % 3 == 2:
            process = bake.start(folder)
            while manifest(folder) is None and process.poll() is None:
                time.sleep(0.001)
            time.sleep(random.uniform(0.0, 0.2))
            end_by(process, signal.SIGKILL)
        more = ("--resume",) if k % 3 == 2 else ()
        ends = []
        one = bake.start(folder, *more)
        time.sleep(random.uniform(0.0, 0.05))
        ends = ends_of([one, bake.start(folder, *more)])
        hold_one_won(bake, folder, ends)
        turned_away += sum(status != DONE for status, _ in ends)
        shutil.rmtree(folder)
        if k % 3 != 0:
            continue
        folders = [built.empty_folder() for _ in range(10)]
        # The cache is kept here: it is what they share.
        shutil.rmtree(built.cache, ignore_errors=True)
        command = lambda folder: [*built.command(folder), "--threads", "1"]
        started = [subprocess.Popen(command(folder), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                    env=built.environment()) for folder in folders]
        for folder, (status, text) in zip(folders, ends_of(started)):
            hold(status == DONE, "%s: of ten from one cache, one ended with %d: %s" % (folder, status, text))
            built.hold_whole(folder)
            shutil.rmtree(folder)
        again = built.empty_folder()
        done = built.run(again)
        hold(done.returncode == DONE, "after ten from one cache: " + done.stderr)
        built.hold_whole(again)
        shutil.rmtree(again)
    return "%d pairs: one bake came to its end in each, %d others were turned away with a message; %d rounds of ten " \
           "bakes from one cache; all bytes equal" % (count, turned_away, (count + 2) // 3)


def drivers(bakes, count):
    """No Vulkan driver, a driver's description that is half a file, and one that names a program."""
    bake = bakes[0]
    root = bake.empty_folder()
    half, program = os.path.join(root, "half.json"), os.path.join(root, "program.json")
    with open(half, "w") as file:
        file.write('{"file_format_version": "1.0')
    with open(program, "w") as file:
        json.dump({"file_format_version": "1.0.0", "ICD": {"library_path": "/bin/true", "api_version": "1.3.0"}}, file)
    names = ("mesa-vulkan-drivers",)
    must_be_found(lambda: hold_refusal(NO_DEVICE, "fascicle: error: no device\n", (NO_DEVICE,), names), "no advice")
    for k in range(count):
        description = (os.path.join(root, "none.json"), half, program)[k % 3]
        # Older loaders know the second name alone.
        environment = bake.environment(VK_DRIVER_FILES=description, VK_ICD_FILENAMES=description)
        folder = os.path.join(root, "out")
        status, text = ended(bake.command(folder, "--device", "vulkan"), environment, root)
        hold_refusal(status, text, (NO_DEVICE,), names)
        hold(not os.path.exists(folder) or not os.listdir(folder), folder + ": something was written")
        status, text = ended([PROGRAM, "devices"], environment, root)
        hold(status == DONE and "cpu" in text, "`devices` ended with %d: %s" % (status, text))
        status, text = ended(bake.command(folder, "--device", "auto"), environment, root)
        hold(status == DONE, "the CPU does not bake: " + text)
        bake.hold_whole(folder)
        shutil.rmtree(folder)
    shutil.rmtree(root)
    return "%d times: the message names the package, and the CPU bakes the same bytes" % count


def memory_of(command, environment):
    """(Most memory it had, bytes; seconds) of a program and its children."""
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment)
    text = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.stderr.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    hold(process.returncode == DONE, "%s ended with %d: %s" % (" ".join(command), process.returncode, text))
    return usage.ru_maxrss * 1024, time.monotonic() - begin


def hold_flat(few, many):
    """Ten times the work may take a tenth more memory, and what a table of its hashes takes."""
    hold(many <= 1.1 * few + (4 << 20), "memory grows with the work: %d MiB, then %d MiB" % (few >> 20, many >> 20))


def load(bakes, count):
    """A bake of so many frames, and a tenth as many jobs of two frames in a batch, each beside a tenth of it."""
    must_be_found(lambda: hold_flat(100 << 20, 200 << 20), "memory that grows")
    bake = bakes[0]
    root = bake.empty_folder()
    environment = bake.environment()
    small = ("--set", "bar.vertices=[4,8,4]", "--device", "cpu", "--threads", "1", "--overwrite")
    found = []
    for frames in (count // 10, count):
        folder = os.path.join(root, "frames")
        found.append(memory_of([PROGRAM, "bake", "bar-hang-none", *small, "--end", repr(frames / 60), "-o", folder],
                               environment))
        hold(len(manifest(folder)["position_hashes"]) == frames + 1, folder + ": frames are missing")
    hold_flat(found[0][0], found[1][0])
    jobs = os.path.join(root, "jobs.toml")
    many = []
    for number in (max(1, count // 100), max(10, count // 10)):
        values = ", ".join("%.6f" % (0.1 + 0.8 * k / number) for k in range(number))
        with open(jobs, "w") as file:
            file.write('format = ["pc2"]\n[job.bar]\nscene = "bar-hang-none"\n'
                       'set = ["scene.end=0.0334", "bar.vertices=[4,8,4]"]\n'
                       '[job.bar.vary]\n"layers.body.alpha" = [%s]\n' % values)
        folder = os.path.join(root, "batch-%d" % number)
        many.append((number, *memory_of([PROGRAM, "batch", jobs, "--device", "cpu", "-o", folder], environment)))
        with open(os.path.join(folder, "batch.json")) as file:
            said = json.dumps(json.load(file))
        hold(said.count('"done"') >= number, folder + ": jobs are missing")
        shutil.rmtree(folder)
    hold_flat(many[0][1], many[1][1])
    shutil.rmtree(root)
    return "%d frames in %d MiB, %.2f times the time a frame of %d frames in %d MiB; %d jobs in %d MiB, %.2f times " \
           "the time a job of %d" % (count, found[1][0] >> 20, found[1][1] / found[0][1] / 10, count // 10,
                                 found[0][0] >> 20, many[1][0], many[1][1] >> 20,
                                 many[1][2] / many[0][2] * many[0][0] / many[1][0], many[0][0])
