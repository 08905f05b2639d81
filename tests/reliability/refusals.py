"""How a program ends that is given what no tool should write: in time, without a crash, and with one error of one
line that names something of the input, says what to do, and tells nothing of its own inside. What takes long has to
say that it is at work."""

import concurrent.futures
import re
import resource
import subprocess
import time

from bakes import Broken, hold, must_be_found

PATIENCE = 120  # s of processor time; a bake here takes less than one, a wrap as fine as a character's some ten
STANDSTILL = 1800  # s on a machine that is busy with other things
SILENCE = 10  # s that it may take without a word: the first is due after 5
AT_ONCE = 2
BAD_USAGE, NOT_FINITE, INTERRUPTED = 2, 5, 75
MEMORY = 8 << 30  # bytes; what asks for more has to say so
# How a line of an error says what to do: by a request, by what would be right, or by the place where the file's
# language is broken.
ADVICE = re.compile(r"; [-`a-z]|\. [A-Z]|not one of |must be |takes |is not a finite number|:\d+: TOML: ")
# What a line of an error must not be: what a library or the language says of itself.
OF_THE_INSIDE = re.compile(r"std::|vector::|_M_|basic_string|bad_alloc|terminate called|Assertion|json\.exception")


# What a line says of work that goes on.
AT_WORK = re.compile(r"^(still |[a-z]+ .*frame \d+/\d+)", re.MULTILINE)


def hold_word(seconds, text):
    """What took long has said so."""
    hold(seconds < SILENCE or AT_WORK.search(text), "%.0f s without a word: %s" % (seconds, text))


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    # SIGXCPU ends it; the mesher has a limit of its own.
    resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, resource.RLIM_INFINITY))


def ended(command, environment, folder):
    """Runs it, its memory and time bounded: (status, all that it says). A signal, no end, or a long silence
    is Broken."""
    begin = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=folder, timeout=STANDSTILL,
                              errors="replace",
                              preexec_fn=limit)
    except subprocess.TimeoutExpired:
        hold(False, "it does not end: " + " ".join(command))
    hold(done.returncode >= 0, "signal %d: %s" % (-done.returncode, " ".join(command)))
    hold_word(time.monotonic() - begin, done.stdout + done.stderr)
    return done.returncode, done.stdout + done.stderr


def ended_or_stopped(command, environment, folder):
    """The same of what may take as long as it was asked to: after a while it must have said that it is at work, and a
    signal must end it with INTERRUPTED."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment,
                               cwd=folder, errors="replace", preexec_fn=limit)
    try:
        text, _ = process.communicate(timeout=SILENCE)
    except subprocess.TimeoutExpired:
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
