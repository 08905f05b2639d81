"""Progress as one line of plain text."""

import logging
import sys
import time


class ProgressBar:
    """A progress line that overwrites itself: progress=ProgressBar().

    `file` is where it is written; None is sys.stderr, which a notebook shows too. If the file is neither a terminal
    nor a notebook, a line is written for each tenth of the work.
    """

    def __init__(self, file=None, width=30):
        self._file = file
        self._width = width
        self._began = None
        self._phase = None
        self._shown_at = -1.0
        self._tenth = -1
        self._length = 0

    def __call__(self, phase, done, total):
        now = time.monotonic()
        if self._began is None or (phase == "build" and self._phase != "build"):
            self._began, self._shown_at, self._tenth = now, -1.0, -1
        self._phase = phase
        file = sys.stderr if self._file is None else self._file
        ends = phase == "frames" and done == total
        if _overwrites(file):
            if not ends and now - self._shown_at < 0.1:
                return
            self._shown_at = now
            text = self.text(phase, done, total, now - self._began)
            file.write("\r" + text.ljust(self._length) + ("\n" if ends else ""))
            self._length = 0 if ends else len(text)
        else:
            tenth = 10 * done // total if phase == "frames" and total else -1
            if tenth <= self._tenth:
                return
            self._tenth = tenth
            file.write(self.text(phase, done, total, now - self._began) + "\n")
        file.flush()

    def _end_line(self):
        """A terminal's next line begins below the bar."""
        if self._length > 0:
            file = sys.stderr if self._file is None else self._file
            file.write("\n")
            file.flush()
            self._length = 0

    def text(self, phase, done, total, seconds):
        """The line, given the seconds since the work began."""
        if phase == "build":
            return "building the body"
        if phase == "lead-in":
            return f"before frame 0: {done} frames"
        full = self._width * done // total if total else self._width
        left = f", {seconds * (total - done) / done:.0f} s left" if 0 < done < total else ""
        return f"[{'#' * full}{'.' * (self._width - full)}] frame {done} of {total}{left}"


def _overwrites(file):
    # A notebook's stderr is not a terminal but supports carriage returns.
    return getattr(file, "isatty", lambda: False)() or type(file).__module__.startswith("ipykernel.")


def progress_function(progress):
    """The callback for `progress`: True is a bar on stderr; None and False are no callback."""
    if progress is True:
        return ProgressBar()
    return None if progress is False else progress


def end_line(progress):
    """Ends the line of a bar after work that has no frames."""
    if isinstance(progress, ProgressBar):
        progress._end_line()


_levels = {"detail": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING}


def log_to_logging(severity, message):
    """The default of `log`: Python's logging, under the name fascicle. By default it shows warnings only."""
    logging.getLogger("fascicle").log(_levels[severity], "%s", message)
