"""What is chosen for a character, kept with its armature in the .blend file, and what that is to the program."""

from types import SimpleNamespace

import bpy
from bpy.props import (BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty,
                       StringProperty)

from . import character

QUALITIES = (("draft", "Draft", "For tries: coarse steps"), ("normal", "Normal", "For most work"),
             ("final", "Final", "Three times as many steps, a seventh to two thirds of the error"))
ATTACHMENTS = (("MESH_CACHE", "Mesh Cache", "A modifier that reads the bake's file: exact, and the scene stays small"),
               ("SHAPE_KEYS", "Shape Keys", "A shape key a frame inside the .blend file: for export to other programs"))
RANGES = (("ACTION", "Action", "From the first to the last key of the action"),
          ("SCENE", "Scene", "The scene's frame range"))
STIFFNESSES = (("youngs_modulus", "Young's Modulus", "Where it rests is the same at every frame rate"),
               ("frequency", "Frequency", "The layer's lowest mode, in hertz"),
               ("fat", "Fat", "As fat is"), ("relaxed-muscle", "Relaxed Muscle", "As a muscle at rest is"),
               ("flexed-muscle", "Flexed Muscle", "As a muscle at work is"), ("skin", "Skin", "As skin is"))

# What a wish changes; each also takes back what another one set.
PLAIN = {"softness": 1.0, "exaggerate": 1.0, "density": 1000.0}
PRESETS = (
    ("PLAIN", "As the Program Chooses", {}),
    ("JIGGLE", "More Jiggle", {"softness": 1.5, "exaggerate": 1.2}),
    ("FIRMER", "Firmer", {"softness": 0.5}),
    ("HEAVIER", "Heavier", {"density": 1600.0}),
    ("CARTOON", "Cartoon", {"softness": 2.0, "exaggerate": 2.0}),
)


class FascicleLayer(bpy.types.PropertyGroup):
    """Flesh below the painted skin of a vertex group, with a stiffness of its own."""

    group: StringProperty(name="Vertex Group",
                          description="Where the weight is 0.5 or more, the flesh below is this layer")
    stiffness: EnumProperty(name="Stiffness", items=STIFFNESSES)
    youngs_modulus: FloatProperty(name="kPa", description="Young's modulus, in kPa", default=20.0, min=0.001,
                                  soft_max=1000.0)
    frequency: FloatProperty(name="Hz", default=4.0, min=0.01, soft_max=60.0)
    damping: FloatProperty(name="Damping", description="How fast motion dies out, in 1/s", default=12.0, min=0.0,
                           soft_max=100.0)


class FascicleAction(bpy.types.PropertyGroup):
    action: PointerProperty(name="Action", type=bpy.types.Action)


class FascicleSettings(bpy.types.PropertyGroup):
    folder: StringProperty(name="Folder", description="Where bakes go, each in a folder of its own",
                           default="//fascicle", subtype="DIR_PATH")
    uses_list: BoolProperty(name="List of Actions",
                            description="Bake the actions of the list, not the one that is open")
    actions: CollectionProperty(type=FascicleAction)
    action_index: IntProperty()
    range: EnumProperty(name="Frames", items=RANGES)
    attachment: EnumProperty(name="Show as", items=ATTACHMENTS)

    softness: FloatProperty(name="Softness", description="How many times as soft all flesh is", default=1.0, min=0.01,
                            max=100.0)
    exaggerate: FloatProperty(name="Exaggerate", description="How many times as far all flesh trails", default=1.0,
                              min=0.0, max=4.0)
    density: FloatProperty(name="Density", description="Of fat and muscle, kg/m^3", default=1000.0, min=1.0,
                           max=100000.0)
    quality: EnumProperty(name="Quality", items=QUALITIES, default="normal")
    contact: BoolProperty(name="Self Contact", description="Flesh does not pass through other flesh of the body",
                          default=True)
    only_bone: StringProperty(name="Only",
                              description="Only the flesh of this bone and of those below it moves by itself")

    bone_group: StringProperty(name="Bone", description="Vertex group: the flesh below is bone")
    muscle_group: StringProperty(name="Muscle", description="Vertex group: the flesh below is muscle")
    fat_group: StringProperty(name="Fat", description="Vertex group: the flesh below is fat")
    rigid_group: StringProperty(name="Rigid", description="Vertex group: skin that follows its bones alone")
    stiffness_group: StringProperty(
        name="Stiffness", description="Vertex group: weights from 0.01 to 1 multiply the stiffness; "
                                      "flesh outside the group keeps its own")
    layers: CollectionProperty(type=FascicleLayer)
    layer_index: IntProperty()


class FascicleState(bpy.types.PropertyGroup):
    """Of the bake at work."""

    is_running: BoolProperty()
    is_cancelled: BoolProperty()
    progress: FloatProperty(name="Progress", subtype="PERCENTAGE", min=0.0, max=100.0)
    message: StringProperty()


class FasciclePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(name="Program", description="The program fascicle; left empty, the one on the PATH",
                            subtype="FILE_PATH")

    def draw(self, context):
        self.layout.prop(self, "program")
        self.layout.label(text="Left empty, the program fascicle on the PATH is taken.")


def apply_preset(settings, identifier):
    wish = next(values for name, _, values in PRESETS if name == identifier)
    for key, value in {**PLAIN, **wish}.items():
        setattr(settings, key, value)


def copy_of(group):
    """The values of a property group, which stay when an undo replaces all that is Blender's. An action is its name."""
    values = {}
    for prop in group.bl_rna.properties:
        value = getattr(group, prop.identifier)
        if prop.type == "COLLECTION":
            value = [copy_of(entry) for entry in value]
        elif prop.type == "POINTER":
            value = value.name if value else None
        values[prop.identifier] = value
    return SimpleNamespace(**values)


def _number(value):
    # Blender's numbers are single; what the user typed is the shortest that gives the same.
    text = "%.7g" % value
    return text if "." in text or "e" in text else text + ".0"


def _layer_text(layer, number, attribute):
    if layer.stiffness in ("youngs_modulus", "frequency"):
        pascals = 1000.0 if layer.stiffness == "youngs_modulus" else 1.0
        stiffness = "%s = %s" % (layer.stiffness, _number(getattr(layer, layer.stiffness) * pascals))
    else:
        stiffness = 'material = "%s"' % layer.stiffness
    where = '{ painted = { attribute = "%s", minimum = 0.5, maximum = 1.0 } }' % attribute
    return "[layers.painted-%d]\n%s\ndamping = %s\nwhere = %s\n" % (number, stiffness, _number(layer.damping), where)


def layers_text(settings):
    """The painted layers as tables of a scene file; empty without any."""
    attributes = character.attribute_names(settings.layers)
    return "\n".join(_layer_text(layer, number, attributes[layer.group])
                     for number, layer in enumerate(settings.layers) if layer.group)


def program_options(settings):
    """The options of `fascicle bake` that say what the panel says."""
    options = ["--quality=" + settings.quality]
    for key in ("softness", "exaggerate"):
        if getattr(settings, key) != PLAIN[key]:
            options.append("--%s=%s" % (key, _number(getattr(settings, key))))
    if settings.density != PLAIN["density"]:
        options += ["--set=layers.%s.density=%s" % (layer, _number(settings.density)) for layer in ("fat", "muscle")]
    if not settings.contact:
        options.append("--set=contact.self=false")
    if settings.only_bone:
        options.append("--only=" + settings.only_bone)
    return options


CLASSES = (FascicleLayer, FascicleAction, FascicleSettings, FascicleState, FasciclePreferences)
