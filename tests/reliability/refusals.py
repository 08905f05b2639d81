"""How a program handles malformed input: within time and memory limits, without a crash, with a one-line error that
names part of the input, says what to do and shows no internals. Long work must report that it is running."""

import concurrent.futures
import os
import re
import resource
import subprocess
import threading
import time

from bakes import Broken, hold, must_be_found

PATIENCE = 120  # s of CPU time; a bake here takes less than one, a wrap with a character's detail about ten
STANDSTILL = 1800  # s of real time, on a busy machine
SILENCE = 10  # s of CPU time allowed without output: the first report is due after 5
AT_ONCE = 2
BAD_USAGE, NOT_FINITE, INTERRUPTED = 2, 5, 75
MEMORY = 512 << 20  # bytes resident; the most measured is a third of this, with a software Vulkan device
# Bytes of address space. A thread reserves 64 MiB without using them. The system refuses requests beyond this.
ADDRESSES = 4 << 30
# How an error line tells the user what to do: an instruction, the valid values, or the place of a TOML syntax error.
ADVICE = re.compile(r"; [-`a-z]|\. [A-Z]|not one of |must (be|ascend)|takes |is not a finite number|:\d+: TOML: ")
# Internals of libraries or the language that an error line must not show.
OF_THE_INSIDE = re.compile(r"std::|vector::|_M_|basic_string|bad_alloc|terminate called|Assertion|json\.exception")


# A progress line.
AT_WORK = re.compile(r"^(still |[a-z]+ .*frame \d+/\d+)", re.MULTILINE)


def hold_word(seconds, text):
    """Long work has reported progress."""
    hold(seconds < SILENCE or AT_WORK.search(text), "%.0f s without output: %s" % (seconds, text))


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    # SIGXCPU ends it. The mesher sets its own limit.
    resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, resource.RLIM_INFINITY))


def started(command, environment, folder):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                            env=environment, cwd=folder, preexec_fn=limit)


def processor_seconds(pid):
    """CPU time of a process and its running children so far; 0 if it has exited."""
    try:
        with open("/proc/%d/stat" % pid) as file:
            times = file.read().rpartition(")")[2].split()[11:15]
        with open("/proc/%d/task/%d/children" % (pid, pid)) as file:
            children = [int(child) for child in file.read().split()]
    except OSError:
        return 0.0
    return sum(map(int, times)) / os.sysconf("SC_CLK_TCK") + sum(map(processor_seconds, children))


def measured(command, environment, folder):
    """Runs a command with limits on memory and time: (exit status, output, peak memory of it or a descendant in bytes).
    Raises Broken for a signal, a hang or a long silence."""
    process = started(command, environment, folder)
    ending = threading.Timer(STANDSTILL, process.kill)
    ending.start()
    try:
        text = process.stdout.read()
        # The usage includes the mesher, a child that the program waits for.
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
    """measured() without the memory."""
    return measured(command, environment, folder)[:2]


def ended_or_stopped(command, environment, folder):
    """(exit status, output) of a command that may run for as long as it likes: after SILENCE it must have reported
    progress, and SIGTERM must end it with INTERRUPTED."""
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
                raise Broken("it does not stop after a signal: " + " ".join(command)) from None
            hold_word(SILENCE, " ".join(command) + "\n" + text)
            hold(process.returncode in (0, INTERRUPTED), "signalled, exited with %d: %s" % (process.returncode, text))
    hold(process.returncode >= 0, "signal %d: %s" % (-process.returncode, " ".join(command)))
    return process.returncode, text


def in_pairs(work, inputs):
    """work(input) for all inputs, several at once, results in order. The first Broken ends it."""
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
    """Controls that the checks must detect."""
    must_be_found(lambda: hold_refusal(1, "fascicle: error: vector::_M_range_check; give another\n", (1,)),
                  "a message that shows internals")
    must_be_found(lambda: hold_refusal(3, "fascicle: error: a.obj: mesh: it is bad\n", (3,)), "an error without advice")
    must_be_found(lambda: ended(["sh", "-c", "kill -SEGV $$"], environment, folder), "a crash")
    must_be_found(lambda: ended(["python3", "-c", "bytearray(1 << 30)"], environment, folder), "too much memory")
    must_be_found(lambda: hold_word(SILENCE + 1, "fascicle 0.1\n"), "a long silence")
    hold_word(SILENCE + 1, "still building the body: 5 s so far\n")
    must_be_found(lambda: list(in_pairs(lambda k: hold(k < 3, "3"), range(9))), "one of several")


def hold_refusal(status, text, allowed, names=()):
    """Exactly one error line: it names part of the input, says what to do and shows no internals."""
    hold(status in allowed, "exited with %d: %s" % (status, text))
    errors = [line for line in text.splitlines() if line.startswith("fascicle: error: ")]
    hold(len(errors) == 1, "%d errors: %s" % (len(errors), text))
    hold(ADVICE.search(errors[0]), "does not say what to do: " + errors[0])
    hold(not OF_THE_INSIDE.search(errors[0]), "shows internals: " + errors[0])
    hold(not names or any(name in errors[0] for name in names), "names none of %s: %s" % (", ".join(names), errors[0]))
