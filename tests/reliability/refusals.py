"""How a program ends that is given what no tool should write: in time, without a crash, and with one error of one
line that names something of the input, says what to do, and tells nothing of its own inside. What takes long has to
say that it is at work."""

import concurrent.futures
import os
import re
import resource
import subprocess
import threading
import time

from bakes import Broken, hold, must_be_found

PATIENCE = 120  # s of processor time; a bake here takes less than one, a wrap as fine as a character's some ten
STANDSTILL = 1800  # s on a machine that is busy with other things
SILENCE = 10  # s of processor time that it may take without a word: the first is due after 5
AT_ONCE = 2
BAD_USAGE, NOT_FINITE, INTERRUPTED = 2, 5, 75
MEMORY = 512 << 20  # bytes in use at once; the most that was seen is a third, of a software device for Vulkan
# Bytes of addresses, of which a thread takes 64 MiB without using them: what asks for more is refused by the system.
ADDRESSES = 4 << 30
# How a line of an error says what to do: by a request, by what would be right, or by the place where the file's
# language is broken.
ADVICE = re.compile(r"; [-`a-z]|\. [A-Z]|not one of |must (be|ascend)|takes |is not a finite number|:\d+: TOML: ")
# What a line of an error must not be: what a library or the language says of itself.
OF_THE_INSIDE = re.compile(r"std::|vector::|_M_|basic_string|bad_alloc|terminate called|Assertion|json\.exception")


# What a line says of work that goes on.
AT_WORK = re.compile(r"^(still |[a-z]+ .*frame \d+/\d+)", re.MULTILINE)


def hold_word(seconds, text):
    """What took long has said so."""
    hold(seconds < SILENCE or AT_WORK.search(text), "%.0f s without a word: %s" % (seconds, text))


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    # SIGXCPU ends it; the mesher has a limit of its own.
    resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, resource.RLIM_INFINITY))


def started(command, environment, folder):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                            env=environment, cwd=folder, preexec_fn=limit)


def processor_seconds(pid):
    """What a process and its children, as far as they are at work, have taken so far; 0 of one that is over."""
    try:
        with open("/proc/%d/stat" % pid) as file:
            times = file.read().rpartition(")")[2].split()[11:15]
        with open("/proc/%d/task/%d/children" % (pid, pid)) as file:
            children = [int(child) for child in file.read().split()]
    except OSError:
        return 0.0
    return sum(map(int, times)) / os.sysconf("SC_CLK_TCK") + sum(map(processor_seconds, children))


def measured(command, environment, folder):
    """Runs it, its memory and time bounded: (status, all that it says, the most memory that it or a child of it had, in
    bytes). A signal, no end, or a long silence is Broken."""
    process = started(command, environment, folder)
    ending = threading.Timer(STANDSTILL, process.kill)
    ending.start()
    try:
        text = process.stdout.read()
        # The mesher is a child of the program, which waits for it: it counts too.
        _, status, usage = os.wait4(process.pid, 0)
    finally:
        ending.cancel()
        process.stdout.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    hold(process.returncode >= 0, "signal %d: %s" % (-process.returncode, " ".join(command)))
    hold_word(usage.ru_utime + usage.ru_stime, text)
    hold(usage.ru_maxrss * 1024 <= MEMORY, "%d MiB: %s" % (usage.ru_maxrss >> 10, " ".join(command)))
    return process.returncode, text, usage.ru_maxrss * 1024


def ended(command, environment, folder):
    """The same without the memory."""
    return measured(command, environment, folder)[:2]


def ended_or_stopped(command, environment, folder):
    """(status, all that it says) of what may take as long as it was asked to: after a while of processor time it must
    have said that it is at work, and a signal must end it with INTERRUPTED."""
    process, begin = started(command, environment, folder), time.monotonic()
    text = None
    while text is None:
        try:
            text, _ = process.communicate(timeout=SILENCE)
        except subprocess.TimeoutExpired:
            if processor_seconds(process.pid) < SILENCE and time.monotonic() - begin < STANDSTILL:
                continue
            process.terminate()
            try:
                text, _ = process.communicate(timeout=STANDSTILL)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
                raise Broken("it goes on after a signal: " + " ".join(command)) from None
            hold_word(SILENCE, " ".join(command) + "\n" + text)
            hold(process.returncode in (0, INTERRUPTED), "stopped, it ended with %d: %s" % (process.returncode, text))
    hold(process.returncode >= 0, "signal %d: %s" % (-process.returncode, " ".join(command)))
    return process.returncode, text


def in_pairs(work, inputs):
    """work(input) of all, some at once, in the order of the inputs. The first that is Broken ends it."""
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        waiting = []
        try:
            for one in inputs:
                waiting.append(pool.submit(work, one))
                if len(waiting) > 4 * AT_ONCE:
                    yield waiting.pop(0).result()
            while waiting:
                yield waiting.pop(0).result()
        finally:
            for one in waiting:
                one.cancel()


def controls(environment, folder):
    """What is not careful, and has to be found out."""
    must_be_found(lambda: hold_refusal(1, "fascicle: error: vector::_M_range_check; give another\n", (1,)),
                  "a message of the inside")
    must_be_found(lambda: hold_refusal(3, "fascicle: error: a.obj: mesh: it is bad\n", (3,)), "no way out")
    must_be_found(lambda: ended(["sh", "-c", "kill -SEGV $$"], environment, folder), "a crash")
    must_be_found(lambda: ended(["python3", "-c", "bytearray(1 << 30)"], environment, folder), "much memory")
    must_be_found(lambda: hold_word(SILENCE + 1, "fascicle 0.1\n"), "a long silence")
    hold_word(SILENCE + 1, "still building the body: 5 s so far\n")
    must_be_found(lambda: list(in_pairs(lambda k: hold(k < 3, "3"), range(9))), "one of several")


def hold_refusal(status, text, allowed, names=()):
    """One error, of one line, that names something of the input, says what to do, and nothing of the inside."""
    hold(status in allowed, "ended with %d: %s" % (status, text))
    errors = [line for line in text.splitlines() if line.startswith("fascicle: error: ")]
    hold(len(errors) == 1, "%d errors: %s" % (len(errors), text))
    hold(ADVICE.search(errors[0]), "does not say what to do: " + errors[0])
    hold(not OF_THE_INSIDE.search(errors[0]), "speaks of the inside: " + errors[0])
    hold(not names or any(name in errors[0] for name in names), "names none of %s: %s" % (", ".join(names), errors[0]))
