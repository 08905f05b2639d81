"""The panel in the sidebar of the 3D view."""

import bpy

from . import attach, character, operators


class FASCICLE_UL_layers(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=item.group or "no vertex group", icon="GROUP_VERTEX" if item.group else "ERROR")
        value = {"youngs_modulus": "%.4g kPa" % item.youngs_modulus, "frequency": "%.4g Hz" % item.frequency}
        row.label(text=value.get(item.stiffness, item.stiffness))


class FASCICLE_UL_actions(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        layout.prop(item, "action", text="", emboss=False, icon="ACTION")


class _Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "fascicle"

    @classmethod
    def poll(cls, context):
        return operators.armature_of(context) is not None


def _draw_list(layout, settings, kind, which, index_name):
    row = layout.row()
    row.template_list(kind, "", settings, which, settings, index_name, rows=3)
    buttons = row.column(align=True)
    for what, icon in (("ADD", "ADD"), ("REMOVE", "REMOVE")):
        button = buttons.operator("fascicle.edit_list", text="", icon=icon)
        button.which, button.what = which, what


class FASCICLE_PT_main(_Panel, bpy.types.Panel):
    bl_idname = "FASCICLE_PT_main"
    bl_label = "Flesh"

    @classmethod
    def poll(cls, context):
        return True

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        armature = operators.armature_of(context)
        if armature is None:
            layout.label(text="Choose an armature, or a mesh on one", icon="INFO")
            return
        settings, state = armature.fascicle, context.window_manager.fascicle
        meshes = character.meshes_of(context, armature)
        names = ", ".join(mesh.name for mesh in meshes[:3]) + (", ..." if len(meshes) > 3 else "")
        layout.label(text=armature.name, icon="ARMATURE_DATA")
        layout.label(text=names or "it moves no mesh that is shown", icon="MESH_DATA" if meshes else "ERROR")
        layout.prop(settings, "uses_list")
        if settings.uses_list:
            _draw_list(layout, settings, "FASCICLE_UL_actions", "actions", "action_index")
        layout.prop(settings, "range")
        layout.prop(settings, "attachment")
        layout.prop(settings, "folder")
        if state.is_running:
            row = layout.row()
            row.enabled = False
            row.prop(state, "progress", slider=True)
            layout.label(text=state.message)
            layout.operator("fascicle.cancel", icon="CANCEL")
            return
        layout.operator("fascicle.bake", icon="PLAY")
        bakes = attach.collections_of(armature)
        if not bakes:
            return
        column = layout.column(align=True)
        for collection in bakes:
            is_shown = not collection.hide_viewport
            column.operator("fascicle.show", text=collection[attach.BAKE],
                            icon="HIDE_OFF" if is_shown else "HIDE_ON").bake = collection[attach.BAKE]
        column.operator("fascicle.show", text="Skinning alone", icon="ARMATURE_DATA").bake = ""
        layout.operator("fascicle.clear", icon="TRASH")


class FASCICLE_PT_flesh(_Panel, bpy.types.Panel):
    bl_parent_id = "FASCICLE_PT_main"
    bl_label = "All Flesh"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        armature = operators.armature_of(context)
        settings = armature.fascicle
        layout.operator_menu_enum("fascicle.preset", "wish", text="Presets")
        for name in ("softness", "exaggerate", "density", "quality", "contact"):
            layout.prop(settings, name)
        layout.prop_search(settings, "only_bone", armature.data, "bones")


class FASCICLE_PT_layers(_Panel, bpy.types.Panel):
    bl_parent_id = "FASCICLE_PT_main"
    bl_label = "Painted Layers"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        armature = operators.armature_of(context)
        settings = armature.fascicle
        # The groups of the active mesh, or of the first; other meshes are asked for groups of the same names.
        meshes = character.meshes_of(context, armature)
        mesh = context.object if context.object in meshes else next(iter(meshes), None)
        if mesh is None:
            return
        column = layout.column()
        for layer in (*character.LAYER_NUMBERS, "rigid", "stiffness"):
            column.prop_search(settings, layer + "_group", mesh, "vertex_groups")
        _draw_list(layout, settings, "FASCICLE_UL_layers", "layers", "layer_index")
        if settings.layer_index < len(settings.layers):
            layer = settings.layers[settings.layer_index]
            column = layout.column()
            column.prop_search(layer, "group", mesh, "vertex_groups")
            column.prop(layer, "stiffness")
            if layer.stiffness in ("youngs_modulus", "frequency"):
                column.prop(layer, layer.stiffness)
            column.prop(layer, "damping")


CLASSES = (FASCICLE_UL_layers, FASCICLE_UL_actions, FASCICLE_PT_main, FASCICLE_PT_flesh, FASCICLE_PT_layers)
