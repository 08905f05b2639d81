"""What fails raises an Error of a kind, with the words of the program."""


class Error(Exception):
    """Says what, where and what to do. `status` is the number that the program would exit with."""

    status = 1


class Failed(Error, RuntimeError):
    """Disk full, out of memory."""

    status = 1


class BadArgument(Error, ValueError):
    """A wrong size, an unknown name, a folder that holds a bake already."""

    status = 2


class BadInput(Error, ValueError):
    """A scene, mesh, character or state that cannot be used."""

    status = 3


class NoSuchDevice(Error, RuntimeError):
    """There is none, or it cannot run this model."""

    status = 4


class NotFinite(Error, ArithmeticError):
    """The simulation left the finite numbers."""

    status = 5


class DeviceFailed(Error, RuntimeError):
    """A device failed or was lost on the way, and no other was named. The same bake with resume=True goes on."""

    status = 7


class Cancelled(Error):
    """A progress callback returned False. The same bake with resume=True goes on."""

    status = 75


def error_of(status, message):
    """The error of a status of the C API."""
    for kind in (BadArgument, BadInput, NoSuchDevice, NotFinite, DeviceFailed, Cancelled):
        if kind.status == status:
            return kind(message)
    return Failed(message)
