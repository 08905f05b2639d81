#include "host/formats/blender_script.h"

#include <algorithm>
#include <iterator>

#include "host/base/text.h"
#include "host/formats/formats.h"

namespace fascicle::formats {

namespace {

// Blender is Z up and the files are Y up. Blender's glTF importer converts the mesh; its OBJ importer rotates
// the object instead, so the mesh keeps the file's axes, like the point cache.
constexpr const char* script_functions = R"python(
import math
import os
import sys

import bpy

FOLDER = os.path.dirname(os.path.abspath(__file__))


def set_timeline():
    """Frame 0 of the bake is Blender's frame FIRST."""
    scene = bpy.context.scene
    scene.render.fps = max(1, math.ceil(FPS - 1e-9))
    scene.render.fps_base = scene.render.fps / FPS
    scene.frame_start = FIRST
    scene.frame_end = FIRST + FRAMES
    scene.frame_set(FIRST)
    scene.unit_settings.system = 'METRIC'


def path_of(name):
    return os.path.join(FOLDER, name)


def new_objects(before):
    return [found for found in bpy.data.objects if found not in before]


def import_obj(name):
    before = set(bpy.data.objects)
    bpy.ops.wm.obj_import(filepath=path_of(name), forward_axis='NEGATIVE_Z', up_axis='Y')
    surface = new_objects(before)[0]
    for polygon in surface.data.polygons:
        polygon.use_smooth = True
    return surface


def add_mesh_cache(surface, name, kind):
    """The vertices of `surface` from a point cache, by its own frame numbers."""
    cache = surface.modifiers.new('fascicle', 'MESH_CACHE')
    cache.cache_format = kind
    cache.filepath = path_of(name)
    cache.deform_mode = 'OVERWRITE'
    cache.interpolation = 'LINEAR'
    cache.time_mode = 'FRAME'
    cache.play_mode = 'SCENE'
    cache.frame_start = FIRST
    # Importing an OBJ turns the object, not its mesh: the mesh is in the file's axes, and so is the cache.
    cache.forward_axis = 'POS_Y'
    cache.up_axis = 'POS_Z'
    return cache


def load_glb():
    before, actions_before = set(bpy.data.objects), set(bpy.data.actions)
    # The importer counts frames in whole frames a second.
    fps, base = bpy.context.scene.render.fps, bpy.context.scene.render.fps_base
    bpy.ops.import_scene.gltf(filepath=path_of('surface.glb'), import_shading='SMOOTH')
    for action in bpy.data.actions:
        if action not in actions_before:
            for curve in curves_of(action):
                stretch(curve, base)
    return new_objects(before)


def curves_of(action):
    """From Blender 4.4 on an action has layers, and from 5.0 on it has nothing else."""
    if not getattr(action, 'layers', None):
        return list(getattr(action, 'fcurves', ()))
    return [curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags
            for curve in bag.fcurves]


def stretch(curve, base):
    """Frames as the importer counts them, from 0 on and in whole frames a second, into those of the scene."""
    if abs(base - 1.0) < 1e-9 and FIRST == 0:
        return
    for point in curve.keyframe_points:
        point.co.x = FIRST + round(point.co.x / base)
    curve.update()


def load_cache(name, kind):
    surface = import_obj('rest.obj')
    add_mesh_cache(surface, name, kind)
    return [surface]


def load_alembic():
    if not hasattr(bpy.ops.wm, 'alembic_import') or not bpy.app.build_options.alembic:
        raise RuntimeError('this Blender was built without Alembic; take glb or pc2')
    before = set(bpy.data.objects)
    bpy.ops.wm.alembic_import(filepath=path_of('surface.abc'), set_frame_range=False, as_background_job=False)
    return new_objects(before)


def load_usd():
    if not hasattr(bpy.ops.wm, 'usd_import') or not bpy.app.build_options.usd:
        raise RuntimeError('this Blender was built without USD; take glb or pc2')
    before = set(bpy.data.objects)
    bpy.ops.wm.usd_import(filepath=path_of('surface.usda'), set_frame_range=False)
    return new_objects(before)
)python";

// The Python function, defined above, that loads a format.
struct Loader {
  const char* format;
  const char* function;
};
// Best-looking first.
constexpr Loader loaders[] = {
    {"glb", "load_glb"},
    {"pc2", "lambda: load_cache('surface.pc2', 'PC2')"},
    {"mdd", "lambda: load_cache('surface.mdd', 'MDD')"},
    {"abc", "load_alembic"},
    {"usda", "load_usd"},
};

constexpr const char* script_end = R"python(
def load(wanted=None):
    """Loads the format named, or the first that is there; the new objects."""
    set_timeline()
    for name, (file, loader) in LOADERS.items():
        if wanted in (None, name) and os.path.exists(path_of(file)):
            return loader()
    raise RuntimeError('%s: holds no %s that Blender can load; fascicle export makes one'
                       % (FOLDER, wanted or ', '.join(LOADERS)))


if __name__ == '__main__':
    # What Blender starts with stands in the way.
    for name in ('Cube', 'Light'):
        if name in bpy.data.objects and '--' not in sys.argv:
            bpy.data.objects.remove(bpy.data.objects[name])
    arguments = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else []
    load(arguments[0] if arguments else None)
)python";

}  // namespace

std::string blender_script(const BlenderScene& scene) {
  std::string names, table;
  for (const Loader& loader : loaders) {
    const Format& format = format_named(loader.format);
    names += (names.empty() ? "" : "|") + format.name;
    table += "    '" + format.name + "': ('" + format.file + "', " + loader.function + "),\n";
  }
  return "# Loads this bake into Blender: blender --python import_blender.py [-- " + names +
         "]\n# Metres; frame 0 of the bake is frame FIRST of Blender.\n\nFPS = " +
         base::number_text(scene.fps) + "\nFRAMES = " + base::number_text(scene.frames) +
         "\nFIRST = " + base::number_text(scene.first_number) + "\n" + script_functions +
         "\n\n# In the order of what looks best.\nLOADERS = {\n" + table + "}\n\n" + script_end;
}

bool blender_loads(const std::filesystem::path& file) {
  return std::any_of(std::begin(loaders), std::end(loaders), [&](const Loader& loader) {
    return file.filename() == format_named(loader.format).file;
  });
}

}  // namespace fascicle::formats
