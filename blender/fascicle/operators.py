"""The buttons: bake, cancel, show, clear, and the lists' own."""

import os
import re
import tempfile

import bpy
from bpy.props import EnumProperty, StringProperty

from . import attach, character, program, settings as chosen
from .problem import Problem

SECONDS_BETWEEN_LOOKS = 0.1

# The bake that is at work in this Blender, if one is; it ends with the add-on.
_running = []


def stop():
    """Ends the bake at work."""
    while _running:
        _running.pop().cancel()


def armature_of(context):
    """The armature that is active, or that moves the active mesh, or for which active flesh was baked; None."""
    found = context.object
    if found is None or found.type == "ARMATURE":
        return found
    if found.type != "MESH":
        return None
    if character.FLESH in found.keys():
        found = attach.object_at(found, character.FLESH)
        if found is None:
            return None
    for modifier in found.modifiers:
        if modifier.type == "ARMATURE" and modifier.object:
            return modifier.object
    return found.parent if found.parent and found.parent.type == "ARMATURE" else None


def _file_name(text):
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "bake"


def _frames_of(scene, action, which):
    if which == "SCENE" or action is None:
        return scene.frame_start, scene.frame_end
    first, last = action.frame_range
    # Keys may stand between frames.
    return int(first // 1), int(-(-last // 1))


class Work:
    """The bakes that one press of the button asks for, one after the other: Blender's side of program.Bake. It keeps
    names and values, none of Blender's objects: an undo while the program works replaces them all."""

    def __init__(self, context, armature):
        self.context, self.scene, self.armature = context, context.scene.name, armature.name
        self.settings = chosen.copy_of(armature.fascicle)
        self.program = program.find_program(context.preferences.addons[__package__].preferences.program)
        self.meshes = [mesh.name for mesh in character.meshes_of(context, armature)]
        if not self.meshes:
            hidden = character.moved_meshes(context.scene, armature)
            if hidden:
                raise Problem("%s moves no mesh that is shown; in the view and for renders, show %s"
                              % (armature.name, " or ".join(mesh.name for mesh in hidden[:3])))
            raise Problem("%s moves no mesh; give a mesh an Armature modifier" % armature.name)
        self.actions = self._actions(armature)
        self._check_names(armature)
        self.folder = self._folder()
        self.warnings = ["%s is hidden, and not baked" % mesh.name
                         for mesh in character.moved_meshes(context.scene, armature) if mesh.name not in self.meshes]
        self.done = []  # names of bakes
        self.at = 0
        self.bake = None
        self.first = 0
        _running.append(self)
        try:
            self._begin()
        except BaseException:
            self.cancel()
            raise

    def _actions(self, armature):
        """Names; None for the armature as it is, without an action."""
        if not self.settings.uses_list:
            data = armature.animation_data
            return [data.action.name if data and data.action else None]
        actions = [entry.action for entry in self.settings.actions if entry.action]
        if not actions:
            raise Problem("The list of actions is empty; add one, or bake the open action")
        return list(dict.fromkeys(actions))

    def _check_names(self, armature):
        """Raises Problem where the bake of one action would replace that of another, in a folder that both would have.
        The bake of an action that has since been renamed may be replaced."""
        baked = [found[attach.BAKE] for found in attach.collections_of(armature)]
        others = [*filter(None, self.actions), *(name for name in baked if name in bpy.data.actions)]
        names = [action.name for action in bpy.data.actions]
        for name in filter(None, self.actions):
            if names.count(name) > 1:
                raise Problem("A library has an action %s too; rename the one of this file" % name)
            for other in others:
                if other != name and _file_name(other) == _file_name(name):
                    raise Problem("The actions %s and %s would be baked into the same folder, %s-%s; rename one of them"
                                  % (name, other, _file_name(armature.name), _file_name(name)))

    def _folder(self):
        path = self.settings.folder
        if path.startswith("//") and not bpy.data.filepath:
            raise Problem("Save the .blend file first, or choose a folder that does not depend on it")
        return bpy.path.abspath(path)

    def _found(self, objects, name):
        found = objects.get(name)
        if found is None:
            raise Problem("%s is no longer there; it was removed or renamed" % name)
        return found

    def _character(self):
        """The armature and its meshes, as they are now."""
        scene = self._found(bpy.data.scenes, self.scene)
        if self.context.scene != scene:
            raise Problem("The scene %s was left while it was baked; open it and bake again" % scene.name)
        objects = scene.objects
        return self._found(objects, self.armature), [self._found(objects, name) for name in self.meshes]

    def _name(self):
        return self.actions[self.at] or self.armature

    def _begin(self):
        """Writes the character in the next action and starts the program."""
        scene = self.context.scene
        armature, meshes = self._character()
        action = self.actions[self.at] and self._found(bpy.data.actions, self.actions[self.at])
        fps = scene.render.fps / scene.render.fps_base
        self.first, last = _frames_of(scene, action, self.settings.range)
        os.makedirs(self.folder, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="fascicle-") as folder:
            path = os.path.join(folder, "character.glb")
            data = armature.animation_data
            before = data.action if data else None
            with character.pose_kept(armature):
                try:
                    if action:
                        data = data or armature.animation_data_create()
                        data.action = action
                    character.write_character(path, self.context, armature, meshes, self.settings, self.first, last,
                                              fps)
                finally:
                    if data:
                        data.action = before
                        scene.frame_set(scene.frame_current)
            options = ["--start=0", "--end=%r" % ((last - self.first) / fps)]
            if 0 <= self.first <= 1000000:
                options.append("--first-frame=%d" % self.first)
            target = os.path.join(self.folder, _file_name(self.armature) + "-" + _file_name(self._name()))
            self.bake = program.Bake(self.program, path, target, fps, options + chosen.program_options(self.settings),
                                     chosen.layers_text(self.settings))

    def step(self, waits=False):
        """True once all is done. `waits`: for the program. Whatever it raises, such as Problem, is the end."""
        try:
            if not (self.bake.wait() if waits else self.bake.poll()):
                return False
            self.warnings += ["%s: %s" % (self._name(), warning) for warning in self.bake.warnings]
            attach.attach(self.context, *self._character(), self._name(), self.bake.folder, self.first,
                          self.settings.attachment)
            self.done.append(self._name())
            self.at += 1
            if self.at < len(self.actions):
                self._begin()
                return False
            self._show_open()
        except BaseException:
            self.cancel()
            raise
        self.cancel()
        return True

    def _show_open(self):
        armature, _ = self._character()
        data = armature.animation_data
        is_open = [name for name in self.done if data and data.action and data.action.name == name]
        attach.show(armature, (is_open or self.done)[-1])

    def share(self):
        """How much of all is done, 0 to 1."""
        part = self.bake.done / self.bake.total if self.bake and self.bake.total else 0.0
        return (self.at + part) / len(self.actions)

    def message(self):
        if not self.bake:
            return ""
        if self.bake.total:
            return "%s: frame %d of %d" % (self._name(), self.bake.done, self.bake.total)
        return "%s: %s" % (self._name(), self.bake.message or "starting")

    def cancel(self):
        """Ends the program, if it runs; bakes that are whole stay."""
        if self in _running:
            _running.remove(self)
        if self.bake:
            self.bake.cancel()


class FASCICLE_OT_bake(bpy.types.Operator):
    """Bake the flesh of this character in the background, and show it"""

    bl_idname = "fascicle.bake"
    bl_label = "Bake Flesh"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return not _running and armature_of(context) is not None

    def execute(self, context):
        """For scripts: waits until all is done."""
        try:
            work = Work(context, armature_of(context))
            while not work.step(waits=True):
                pass
        except (Problem, OSError) as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        self._report(work)
        return {"FINISHED"}

    def invoke(self, context, event):
        try:
            self._work = Work(context, armature_of(context))
        except (Problem, OSError) as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        state = context.window_manager.fascicle
        state.is_running, state.is_cancelled, state.progress, state.message = True, False, 0.0, "starting"
        self._timer = context.window_manager.event_timer_add(SECONDS_BETWEEN_LOOKS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        state = context.window_manager.fascicle
        if state.is_cancelled or self._work not in _running:
            self.cancel(context)
            self.report({"INFO"}, "The bake was cancelled; nothing of it is left")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            is_done = self._work.step()
        except (Problem, OSError) as problem:
            self._finish(context)
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        except BaseException:
            self._finish(context)
            raise
        if is_done:
            self._finish(context)
            self._report(self._work)
            return {"FINISHED"}
        state.progress, state.message = 100.0 * self._work.share(), self._work.message()
        self._redraw(context)
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Blender calls this too, when it closes or loads another file."""
        self._work.cancel()
        self._finish(context)

    def _finish(self, context):
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.fascicle.is_running = False
        self._redraw(context)

    def _redraw(self, context):
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()

    def _report(self, work):
        for warning in work.warnings:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, "Baked " + ", ".join(work.done))


class FASCICLE_OT_cancel(bpy.types.Operator):
    """End the bake at work; nothing of it is kept"""

    bl_idname = "fascicle.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return bool(_running)

    def execute(self, context):
        context.window_manager.fascicle.is_cancelled = True
        stop()
        return {"FINISHED"}


class FASCICLE_OT_clear(bpy.types.Operator):
    """Take the flesh away and show the meshes by skinning again; the folders of the bakes stay"""

    bl_idname = "fascicle.clear"
    bl_label = "Clear"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        armature = armature_of(context)
        return armature is not None and bool(attach.collections_of(armature))

    def execute(self, context):
        armature = armature_of(context)
        count = attach.clear(armature)
        self.report({"INFO"}, "Took away %d bake%s" % (count, "" if count == 1 else "s"))
        return {"FINISHED"}


class FASCICLE_OT_show(bpy.types.Operator):
    """Show this bake in place of the others, and open its action"""

    bl_idname = "fascicle.show"
    bl_label = "Show"
    bl_options = {"REGISTER", "UNDO"}

    bake: StringProperty(description="Its name; empty: skinning alone")

    @classmethod
    def poll(cls, context):
        return armature_of(context) is not None

    def execute(self, context):
        armature = armature_of(context)
        attach.show(armature, self.bake or None)
        action = bpy.data.actions.get(self.bake)
        if action and armature.animation_data:
            armature.animation_data.action = action
        return {"FINISHED"}


class FASCICLE_OT_preset(bpy.types.Operator):
    """Set softness, exaggeration and density as this wish has them"""

    bl_idname = "fascicle.preset"
    bl_label = "Preset"
    bl_options = {"REGISTER", "UNDO"}

    wish: EnumProperty(items=[(name, label, "") for name, label, _ in chosen.PRESETS])

    @classmethod
    def poll(cls, context):
        return armature_of(context) is not None

    def execute(self, context):
        chosen.apply_preset(armature_of(context).fascicle, self.wish)
        return {"FINISHED"}


class FASCICLE_OT_edit_list(bpy.types.Operator):
    """Add an entry, or remove the one that is chosen"""

    bl_idname = "fascicle.edit_list"
    bl_label = "Edit List"
    bl_options = {"REGISTER", "UNDO"}

    which: EnumProperty(items=(("layers", "Layers", ""), ("actions", "Actions", "")))
    what: EnumProperty(items=(("ADD", "Add", ""), ("REMOVE", "Remove", "")))

    @classmethod
    def poll(cls, context):
        return armature_of(context) is not None

    def execute(self, context):
        armature = armature_of(context)
        entries = getattr(armature.fascicle, self.which)
        index_name = "layer_index" if self.which == "layers" else "action_index"
        index = getattr(armature.fascicle, index_name)
        if self.what == "ADD":
            added = entries.add()
            index = len(entries) - 1
            if self.which == "actions" and armature.animation_data:
                added.action = armature.animation_data.action
            if self.which == "layers" and context.object.type == "MESH" and context.object.vertex_groups.active:
                added.group = context.object.vertex_groups.active.name
        elif index < len(entries):
            entries.remove(index)
            index = max(0, index - 1)
        setattr(armature.fascicle, index_name, index)
        return {"FINISHED"}


CLASSES = (FASCICLE_OT_bake, FASCICLE_OT_cancel, FASCICLE_OT_clear, FASCICLE_OT_show, FASCICLE_OT_preset,
           FASCICLE_OT_edit_list)
