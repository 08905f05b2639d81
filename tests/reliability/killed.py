"""SIGKILL during bakes and exports: files with final names are complete, nothing is lost, and the work can be
resumed."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time

from bakes import (DONE, GROWING, PROGRAM, Bake, Kept, control_of_files, control_of_going_on, digest, files, hold,
                   killed_at_work, must_be_found)
from failing_calls import count_of, counted_calls, plan

# When a kill can arrive, judged by the state of the folder.
PHASES = ("building", "settling", "frames", "ends of files", "export")
EVERY_FORMAT = "abc,glb,mdd,obj,pc2,usda,vtp"  # all that export writes; vtu needs velocities

# A careless writer: files get their final names before their bytes are written.
NAIVE = """import os, sys, time
source, folder = sys.argv[1:]
paths = [os.path.join(parent, name) for parent, _, names in os.walk(source) for name in names]
names = [os.path.relpath(path, source) for path in sorted(paths, key=os.path.getsize, reverse=True)]
names = [name for name in names if name not in ("manifest.json", "checkpoint")]
print("begins", flush=True)
for name in names:
    os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
    with open(os.path.join(source, name), "rb") as old, open(os.path.join(folder, name), "wb") as new:
        content = old.read()
        for k in range(4):
            new.write(content[k * len(content) // 4:(k + 1) * len(content) // 4])
            new.flush()
            time.sleep(0.005)
"""


class Export:
    """Exports of a finished bake, over the files of an older export with other settings."""

    name = "export"

    def __init__(self, bake):
        self.root, self.bake = bake.root, bake
        self.source = bake.empty_folder()
        shutil.copytree(bake.folder_of_whole, self.source, dirs_exist_ok=True)
        self.of_source = self.all_in(self.source)
        self.older = self.exported("--first-frame", "1001", "--glb-stride", "3")
        self.before = files(self.older)
        begin = time.monotonic()
        self.newer = self.exported()
        self.seconds = time.monotonic() - begin
        self.after = files(self.newer)
        hold(set(self.before) - set(self.after) and self.before["surface.glb"] != self.after["surface.glb"],
             "the two exports are the same")
        # Streams have the same name in both exports. Of per-frame files, either set must be complete.
        self.common = {name for name in self.before if os.sep not in name}
        self.folders = {name.split(os.sep)[0] for name in self.before if os.sep in name}

    def exported(self, *more):
        folder = self.bake.empty_folder()
        done = subprocess.run(self.command(folder, *more), capture_output=True, text=True)
        hold(done.returncode == DONE, done.stderr)
        return folder

    @staticmethod
    def all_in(folder):
        found = {}
        for parent, _, names in os.walk(folder):
            for name in names:
                path = os.path.join(parent, name)
                found[os.path.relpath(path, folder)] = digest(path)
        return found

    def command(self, folder, *more):
        return [PROGRAM, "export", self.source, "--to", EVERY_FORMAT, "-o", folder, *more]

    def start(self, folder, *more, **environment):
        return subprocess.Popen(self.command(folder, "--overwrite"), stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, start_new_session=True,
                                env={**os.environ, **environment})

    def moment(self):
        return random.uniform(0.0, self.seconds)

    def folder_of_older(self):
        folder = self.bake.empty_folder()
        shutil.copytree(self.older, folder, dirs_exist_ok=True)
        return folder

    def hold_whole_files(self, folder):
        """Every file is from the older or the newer export, and none is lost."""
        found = files(folder)
        for name, content in found.items():
            hold(content in (self.before.get(name), self.after.get(name)), "%s/%s: bytes differ" % (folder, name))
        hold(self.common <= set(found), "%s: lost %s" % (folder, ", ".join(sorted(self.common - set(found)))))
        for inner in self.folders:
            hold(any({name for name in of if name.startswith(inner + os.sep)} <= set(found)
                     for of in (self.before, self.after)), "%s/%s: lost a frame" % (folder, inner))
        hold(self.all_in(self.source) == self.of_source, self.source + ": the exported bake has changed")

    def finish(self, folder):
        done = subprocess.run(self.command(folder, "--overwrite"), capture_output=True, text=True)
        hold(done.returncode == DONE, "%s: the next export exited with %d: %s" % (folder, done.returncode, done.stderr))
        hold(self.all_in(folder) == self.after, folder + ": files differ from an undisturbed export")


def export_of(bake):
    """Shared by all rows."""
    if not hasattr(bake, "export"):
        bake.export = Export(bake)
    return bake.export


class Naive(Bake):
    """A bake by the careless writer."""

    def __init__(self, bake):
        super().__init__("naive", ())
        self.root, self.cache, self.whole, self.hashes = bake.root, bake.cache, bake.whole, bake.hashes
        self.source = self.folder_of_whole = bake.folder_of_whole
        self.seconds = 0.5

    def command(self, folder, *more):
        return [sys.executable, "-c", NAIVE, self.source, folder]

    def start(self, folder, *more):
        """Returns once writing begins."""
        process = subprocess.Popen(self.command(folder), stdout=subprocess.PIPE, text=True, start_new_session=True)
        process.stdout.readline()
        return process


def control_of_writer(bake, export):
    """Control: the careless writer, killed in the same way, as a bake and as an export."""
    naive = Naive(bake)

    def as_bake():
        for _ in range(20):
            folder = naive.empty_folder()
            killed_at_work(naive, folder)
            naive.hold_published(folder)
            shutil.rmtree(folder)

    def as_export():
        naive.source = export.newer
        for _ in range(20):
            folder = export.folder_of_older()
            killed_at_work(naive, folder)
            export.hold_whole_files(folder)
            shutil.rmtree(folder)

    must_be_found(as_bake, "a bake that names files before writing them")
    must_be_found(as_export, "an export that names files before writing them")


def stamp(folder):
    """Identifies the manifest file; changes once a bake has marked itself there as running."""
    try:
        of = os.stat(os.path.join(folder, "manifest.json"))
        return of.st_ino, of.st_mtime_ns
    except FileNotFoundError:
        return None


def phase_of(bake, folder, before):
    """The phase in which a bake was killed or stopped; `before`: the manifest's stamp when it began."""
    if stamp(folder) in (before, None):
        return "building"
    if not os.path.exists(os.path.join(folder, GROWING)):
        return "settling"
    return "frames" if bake.frames_in(folder) < len(bake.hashes) else "ends of files"


class AtCalls:
    """Kills a bake or an export before a random call that changes a file in its folder: any, or one of the last, which
    a random moment hardly ever hits."""

    LAST = 40

    def __init__(self, subject):
        folder = subject.folder_of_older() if isinstance(subject, Export) else subject.empty_folder()

        def run(**environment):
            process = subject.start(folder, **environment)
            return subprocess.CompletedProcess(process.args, process.wait(), "", process.stderr.read())

        self.calls = counted_calls(run, folder)
        shutil.rmtree(folder)

    def __call__(self, subject, folder, *more):
        number = random.randint(random.choice((1, max(1, self.calls - self.LAST))), self.calls)
        process = subject.start(folder, *more, **plan(folder, number, 0, "kill"))
        text = process.communicate()[1]
        was_killed = process.returncode == -signal.SIGKILL
        hold(was_killed or process.returncode == DONE, "%s: exited with %d: %s" % (folder, process.returncode, text))
        if not was_killed and os.path.exists(count_of(folder)):
            os.remove(count_of(folder))
        return was_killed


class Tally:
    def __init__(self):
        self.kills = dict.fromkeys(PHASES, 0)
        self.late = self.went_on = self.anew = self.at_calls = 0

    def all(self):
        return sum(self.kills.values())


def kill_bake(bake, kill, times, tally):
    """Kills a bake `times` times in a row, then resumes it to the end."""
    folder = bake.empty_folder()
    more = ()
    for _ in range(times):
        with Kept(folder) as kept:
            before = stamp(folder)
            if kill(bake, folder, *more):
                tally.kills[phase_of(bake, folder, before)] += 1
            else:
                tally.late += 1
            bake.hold_counted(folder)
            kept.hold_still_there()
        more = ("--resume",)
    if bake.resume(folder):
        tally.went_on += 1
    else:
        tally.anew += 1
    shutil.rmtree(folder)


def kill_export(export, kill, times, tally):
    folder = export.folder_of_older()
    for _ in range(times):
        if kill(export, folder):
            tally.kills["export"] += 1
        else:
            tally.late += 1
        export.hold_whole_files(folder)
    export.finish(folder)
    shutil.rmtree(folder)


def killed(bakes, count):
    """SIGKILL ends a bake at a random moment, several times in a row, and the bake is then resumed. It also ends
    exports that write every format over an older export. One kill in five comes right before a call that changes a
    file, and half of these near the end. After each kill, every file under its final name is complete,
    no published file or frame is gone, and `fascicle verify` accepts every frame that the manifest counts. A bake that
    had a checkpoint continues from it."""
    control_of_files(bakes)
    control_of_going_on(bakes)
    export = export_of(bakes[1])
    control_of_writer(bakes[0], export)
    tally = Tally()
    subjects = [*bakes, export]
    most = max(1, min(4, count // len(subjects)))
    at_calls = {subject: AtCalls(subject) for subject in (subjects if count > len(subjects) else subjects[:1])}
    turn = 0
    while tally.all() < count:
        for subject in subjects:
            times, turn, before = min(random.randint(1, most), count - tally.all()), turn + 1, tally.all()
            is_at_call = turn % 5 == 1 and subject in at_calls
            kill = at_calls[subject] if is_at_call else killed_at_work
            if times > 0:
                (kill_export if subject is export else kill_bake)(subject, kill, times, tally)
            tally.at_calls += tally.all() - before if is_at_call else 0
        hold(tally.late <= 20 + 5 * tally.all(),
             "hardly any were still running when killed: %d of %d" % (tally.all(), tally.all() + tally.late))
    hold(tally.at_calls, "no kill came before a call: the library is not preloaded or does not work")
    # Enough kills that each phase must have had one.
    hold(count < 200 or all(tally.kills.values()), "a phase had no kill: %s" % tally.kills)
    return "%d kills hit a bake at work (%s), %d of them right before a call that changes a file; %d more came after " \
           "its end; 0 files torn or lost; %d bakes continued from their checkpoint, %d had none yet and started " \
           "over; every file ended up with the bytes of an uninterrupted bake or export" % (
               tally.all(), ", ".join("%s %d" % pair for pair in tally.kills.items()), tally.at_calls, tally.late,
               tally.went_on, tally.anew)
