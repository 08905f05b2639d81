"""fascicle: bakes how muscle and fat of animated characters stretch, lag and jiggle.

    import fascicle

    fascicle.bake("man.glb", clip="jump", layers={"fat": {"material": "fat"}}, formats=["glb"], progress=True)

Three levels: bake a scene (bake); build a model and step it frame by frame with a clip or your own poses (Scene,
Model, Solver); or use the solver alone, on flat arrays (Model.of_arrays, Solver.step_drive).

Metres, kilograms, seconds, radians; right-handed, Y up. Errors are subclasses of fascicle.Error, whose message says
what, where and what to do. The library releases the GIL while it works. Ctrl-C ends a bake after the frames in
progress.
"""

import os as _os

from ._errors import BadArgument, BadInput, Cancelled, DeviceFailed, Error, Failed, NoSuchDevice, NotFinite
from ._fascicle import BakeResult, Device, Model, Scene, Solver, builtin_scenes, formats, solver_version
from ._fascicle import run_bake as _run_bake
from ._fascicle import version as __version__
from ._progress import ProgressBar
from ._progress import log_to_logging as _log_to_logging
from ._progress import progress_function as _progress_function

__all__ = [
    "BadArgument", "BadInput", "BakeResult", "Cancelled", "Device", "DeviceFailed", "Error", "Failed", "Model", "NoSuchDevice",
    "NotFinite", "ProgressBar", "Scene", "Solver", "bake", "builtin_scenes", "formats", "solver_version",
]

def bake(scene, folder=None, *, clip=None, fps=None, start=None, end=None, softness=None, exaggerate=None, converter=None,
         set=None, formats=(), device="auto", threads=0, mesher=None, cache=None, overwrite=False, resume=False,
         keep_frames=True, usd_skel=False, first_frame=None, glb_stride=1, glb_error=None, glb_tolerance=None,
         glb_compress=None, progress=None, log=_log_to_logging, **tables):
    """Builds, simulates and writes a scene, as `fascicle bake` does, with the same bytes.

    scene          a Scene, or what Scene takes: a scene file, a mesh, a character or a built-in scene
    folder         the output folder; None: out/ and the scene's name
    clip, fps, start, end, softness, exaggerate, converter, set, **tables
                   as for Scene: layers={"fat": {"material": "fat"}}. Not allowed with a Scene object
    formats        what to write in addition to frame cache, manifest and metrics: see formats(); "none": nothing
    device         as for Device. Several may be given, "vulkan:0,cpu": if one fails, the next continues
    threads        of the CPU solver; 0: one per core
    mesher         the program fascicle-mesher; None: found beside the library, in its prefix or on PATH
    cache          folder for filled bodies, starts and compiled shaders; "": none; None: the program's default
    overwrite      replaces the bake in the folder
    resume         continues the bake in the folder, to the same bytes
    keep_frames    False: deletes the frame cache once the formats are complete; nothing can be exported or drawn later.
                   Needs a format, or formats="none" if you want only the metrics
    usd_skel       usda also holds the character by skinning alone
    first_frame    number of the first frame in the files for other programs; None: they begin at 0
    glb_stride     glb: one morph target per this many frames
    glb_error      glb: as few targets as keep a viewer within this error, m; None: use the stride
    glb_tolerance  glb: vertices nearer than this to skinning are only skinned, m; None: almost none
    glb_compress   glb: quantise with at most this error, m, and compress; None: do not
    progress       True: a bar on stderr; or a function called with (phase, done, total): ("build", 0, 0) repeatedly
                   while the model is built, ("lead-in", done, 0) before each frame stepped before frame 0, and
                   ("frames", done, total) after each frame. Returning False or raising ends the bake
    log            a function called with ("detail", "info" or "warning", message). The default is Python's logging
                   under the name "fascicle"; None: no messages

    Returns a BakeResult. Raises Cancelled if progress returned False, and KeyboardInterrupt on Ctrl-C; the same bake
    with resume=True continues to the same bytes. Raises BadArgument if the folder already holds a bake.
    """
    chosen = {"clip": clip, "fps": fps, "start": start, "end": end, "softness": softness, "exaggerate": exaggerate,
              "converter": converter, "set": set}
    if isinstance(scene, Scene):
        given = [name for name, value in chosen.items() if value is not None] + list(tables)
        if given:
            raise TypeError(f"{given[0]} belongs to the scene; give it to fascicle.Scene")
    else:
        scene = Scene(scene, **chosen, **tables)
    if isinstance(formats, str):
        formats = [name.strip() for name in formats.split(",")]
    return _run_bake(
        scene, _os.path.join("out", scene.name) if folder is None else folder, formats=list(formats), device=device,
        threads=threads, mesher=mesher, cache=cache, overwrite=overwrite, resume=resume, keep_frames=keep_frames,
        usd_skel=usd_skel, first_frame=first_frame, glb_stride=glb_stride, glb_error=glb_error,
        glb_tolerance=glb_tolerance, glb_compress=glb_compress, progress=_progress_function(progress), log=log)
