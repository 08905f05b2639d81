"""fascicle in Blender: bakes the flesh of a character that an armature moves, by the program `fascicle`.

The add-on hands the program a glTF file of the character and shows what comes back. All of the work is the program's.
Blender 3.4 and later."""

bl_info = {
    "name": "fascicle",
    "author": "The fascicle authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > fascicle",
    "description": "Bakes how muscle and fat of a character stretch, lag and jiggle",
    "category": "Animation",
}

import bpy

from . import operators, panel, settings

MODULES = (settings, operators, panel)


def register():
    for module in MODULES:
        for kind in module.CLASSES:
            bpy.utils.register_class(kind)
    bpy.types.Object.fascicle = bpy.props.PointerProperty(type=settings.FascicleSettings)
    bpy.types.WindowManager.fascicle = bpy.props.PointerProperty(type=settings.FascicleState)


def unregister():
    operators.stop()
    del bpy.types.WindowManager.fascicle
    del bpy.types.Object.fascicle
    for module in reversed(MODULES):
        for kind in reversed(module.CLASSES):
            bpy.utils.unregister_class(kind)
