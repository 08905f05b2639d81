"""fascicle: bakes how muscle and fat of animated characters stretch, lag and jiggle.

    import fascicle

    fascicle.bake("man.glb", clip="jump", layers={"fat": {"material": "fat"}}, formats=["glb"], progress=True)

Three levels: bake a scene (bake); build a model and step its frames by a clip or by poses of your own (Scene,
Model, Solver); or only the solver, on flat arrays (Model.of_arrays, Solver.step_drive).

Metres, kilograms, seconds, radians; right-handed, Y up. What fails raises a kind of fascicle.Error, which says
what, where and what to do. The library works without the interpreter's lock. Ctrl-C ends a bake after the frames
that are under way.
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
    folder         to write; None: out/ and the scene's name
    clip, fps, start, end, softness, exaggerate, converter, set, **tables
                   as Scene takes them: layers={"fat": {"material": "fat"}}. Not beside a Scene
    formats        what to write beside frame cache, manifest and metrics: see formats(); "none": nothing
    device         as Device takes it; of several, "vulkan:0,cpu", the next goes on where one fails
    threads        of the CPU solver; 0: one for each core
    mesher         the program fascicle-mesher; None: found beside the library, in its prefix or on PATH
    cache          folder for filled bodies, starts and compiled shaders; "": none; None: as the program's
    overwrite      replaces the bake that is in the folder
    resume         goes on with the bake that is in the folder, to the same bytes
    keep_frames    False: the frame cache goes once the formats are whole; nothing can be exported or drawn later. Takes
                   a format, or formats="none" where the metrics are all you want
    usd_skel       in usda skinning alone stands beside the baked points
    first_frame    number of the first frame in what other programs read; None: what is written begins at 0
    glb_stride     glb: a morph target every so many frames
    glb_error      glb: as few targets as keep a viewer this near, m; None: by the stride
    glb_tolerance  glb: vertices nearer than this to skinning are left to it, m; None: next to nothing
    glb_compress   glb: quantised by this much at most, m, and compressed; None: not
    progress       True: a bar on stderr; or called with (phase, done, total): ("build", 0, 0) again and again while
                   the model is built, ("lead-in", done, 0) before each frame that is stepped before frame 0, and
                   ("frames", done, total) after each frame. False or an exception ends the bake
    log            called with ("detail", "info" or "warning", message). The default is Python's logging under the
                   name "fascicle"; None: nobody listens

    Returns a BakeResult. Raises Cancelled where progress returned False, and KeyboardInterrupt on ctrl-C; the same
    bake with resume=True goes on to the same bytes. Raises BadArgument where the folder holds a bake already.
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
        formats = formats.split(",")
    return _run_bake(
        scene, _os.path.join("out", scene.name) if folder is None else folder, formats=list(formats), device=device,
        threads=threads, mesher=mesher, cache=cache, overwrite=overwrite, resume=resume, keep_frames=keep_frames,
        usd_skel=usd_skel, first_frame=first_frame, glb_stride=glb_stride, glb_error=glb_error,
        glb_tolerance=glb_tolerance, glb_compress=glb_compress, progress=_progress_function(progress), log=log)
