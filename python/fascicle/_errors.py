"""The exceptions: subclasses of Error, with the program's messages."""


class Error(Exception):
    """The message says what, where and what to do. `status` is the exit status that the program would return."""

    status = 1


class Failed(Error, RuntimeError):
    """Disk full or out of memory, for example."""

    status = 1


class BadArgument(Error, ValueError):
    """A wrong size, an unknown name, or a folder that already holds a bake."""

    status = 2


class BadInput(Error, ValueError):
    """A scene, mesh, character or state that cannot be used."""

    status = 3


class NoSuchDevice(Error, RuntimeError):
    """The device does not exist, or cannot run this model."""

    status = 4


class NotFinite(Error, ArithmeticError):
    """The simulation produced infinity or NaN."""

    status = 5


class DeviceFailed(Error, RuntimeError):
    """A device failed or was lost during the work, and no other was named. The same bake with resume=True continues."""

    status = 7


class Cancelled(Error):
    """A progress callback returned False. The same bake with resume=True continues."""

    status = 75


def error_of(status, message):
    """The exception for a status of the C API."""
    for kind in (BadArgument, BadInput, NoSuchDevice, NotFinite, DeviceFailed, Cancelled):
        if kind.status == status:
            return kind(message)
    return Failed(message)
