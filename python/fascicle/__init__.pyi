from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TextIO, Union

import numpy as np
import numpy.typing as npt

__version__: str
solver_version: int

_Path = Union[str, PathLike[str]]
_Settings = Union[Mapping[str, Any], Sequence[str]]
_Phase = Literal["build", "lead-in", "frames"]
_Progress = Callable[[_Phase, int, int], Union[bool, None]]
_Log = Callable[[Literal["detail", "info", "warning"], str], object]
_Triple = Union[Sequence[float], npt.NDArray[Any]]

class Error(Exception):
    status: int

class Failed(Error, RuntimeError): ...
class BadArgument(Error, ValueError): ...
class BadInput(Error, ValueError): ...
class NoSuchDevice(Error, RuntimeError): ...
class DeviceFailed(Error, RuntimeError): ...
class NotFinite(Error, ArithmeticError): ...
class Cancelled(Error): ...

def formats() -> list[str]: ...
def builtin_scenes() -> list[str]: ...

class Scene:
    def __init__(
        self,
        name: _Path,
        *,
        set: _Settings | None = None,
        clip: str | None = None,
        fps: float | None = None,
        start: float | None = None,
        end: float | None = None,
        softness: float | None = None,
        exaggerate: float | None = None,
        converter: _Path | None = None,
        **tables: Mapping[str, Any],
    ) -> None: ...
    @staticmethod
    def parse(
        text: str,
        folder: _Path = "",
        *,
        set: _Settings | None = None,
        clip: str | None = None,
        fps: float | None = None,
        start: float | None = None,
        end: float | None = None,
        softness: float | None = None,
        exaggerate: float | None = None,
        converter: _Path | None = None,
        **tables: Mapping[str, Any],
    ) -> Scene: ...
    @property
    def name(self) -> str: ...
    @property
    def fps(self) -> float: ...
    @property
    def frame_count(self) -> int: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def joint_parents(self) -> list[int]: ...
    @property
    def clip_names(self) -> list[str]: ...

class BakeResult:
    @property
    def folder(self) -> str: ...
    @property
    def frames(self) -> int: ...
    @property
    def position_hash(self) -> str: ...
    @property
    def look(self) -> float: ...
    @property
    def files(self) -> list[str]: ...

def bake(
    scene: Scene | _Path,
    folder: _Path | None = None,
    *,
    clip: str | None = None,
    fps: float | None = None,
    start: float | None = None,
    end: float | None = None,
    softness: float | None = None,
    exaggerate: float | None = None,
    converter: _Path | None = None,
    set: _Settings | None = None,
    formats: str | Sequence[str] = (),
    device: str = "auto",
    threads: int = 0,
    mesher: _Path | None = None,
    cache: _Path | None = None,
    overwrite: bool = False,
    resume: bool = False,
    keep_frames: bool = True,
    usd_skel: bool = False,
    first_frame: int | None = None,
    glb_stride: int = 1,
    glb_error: float | None = None,
    glb_tolerance: float | None = None,
    glb_compress: float | None = None,
    progress: _Progress | bool | None = None,
    log: _Log | None = ...,
    **tables: Mapping[str, Any],
) -> BakeResult: ...

class ProgressBar:
    def __init__(self, file: TextIO | None = None, width: int = 30) -> None: ...
    def __call__(self, phase: _Phase, done: int, total: int) -> None: ...
    def text(self, phase: _Phase, done: int, total: int, seconds: float) -> str: ...

class Device:
    def __init__(self, name: str = "auto", threads: int = 0, cache: _Path | None = None) -> None: ...
    @property
    def text(self) -> str: ...
    @property
    def is_exact(self) -> bool: ...

class Model:
    def __init__(
        self,
        scene: Scene,
        *,
        mesher: _Path | None = None,
        cache: _Path | None = None,
        progress: _Progress | bool | None = None,
        log: _Log | None = ...,
    ) -> None: ...
    @staticmethod
    def of_arrays(arrays: dict[str, npt.NDArray[Any] | list[str]]) -> Model: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def tetrahedron_count(self) -> int: ...
    @property
    def surface_vertex_count(self) -> int: ...
    @property
    def joint_count(self) -> int: ...
    @property
    def substeps(self) -> int: ...
    @property
    def arrays(self) -> dict[str, npt.NDArray[Any] | list[str]]: ...

class Solver:
    def __init__(
        self,
        model: Model,
        device: Device | None = None,
        *,
        rotation: str | None = None,
        iterations: int | None = None,
        viscosity: float | None = None,
    ) -> None: ...
    def start_clip(self, progress: _Progress | bool | None = None) -> None: ...
    def step_clip(self) -> None: ...
    def start_pose(self, joints: npt.NDArray[np.float64] | None = None) -> None: ...
    def step_pose(
        self, joints: npt.NDArray[np.float64] | None = None, *, time: float | None = None, jumps: bool = False
    ) -> None: ...
    def clip_pose(self, frame: int) -> npt.NDArray[np.float64]: ...
    def step_drive(
        self,
        *,
        h: float,
        substeps: int = 1,
        origin: _Triple = ...,
        origin_shift: _Triple = ...,
        gravity: _Triple = ...,
        bones: npt.NDArray[np.float32] | None = None,
        muscles: npt.NDArray[np.float32] | None = None,
        forces: npt.NDArray[np.float32] | None = None,
        decay: npt.NDArray[np.float32] | None = None,
        colliders: npt.NDArray[np.float32] | None = None,
    ) -> None: ...
    @property
    def positions(self) -> npt.NDArray[np.float32]: ...
    @property
    def velocities(self) -> npt.NDArray[np.float32]: ...
    @property
    def surface(self) -> npt.NDArray[np.float32]: ...
    def world_positions(self, out: npt.NDArray[np.float32] | None = None) -> npt.NDArray[np.float32]: ...
    def world_surface(self, out: npt.NDArray[np.float32] | None = None) -> npt.NDArray[np.float32]: ...
    @property
    def frame(self) -> int: ...
    @property
    def unit(self) -> float: ...
    @property
    def origin(self) -> npt.NDArray[np.float64]: ...
    @property
    def position_hash(self) -> str: ...
    @property
    def device(self) -> str: ...
    def save(self) -> bytes: ...
    def load(self, state: bytes) -> None: ...
