"""blender_picture.py BUILD PICTURE: Blender's window with the add-on's panel and a baked bear, for docs/blender.md.

Started by `./do blender`, on a display of Xvfb; runs itself again inside Blender, where it presses the button."""
import os
import subprocess
import sys
import tempfile

WINDOW = (1440, 900)
# The position of the add-on's tab in the window, x from the left and y from the bottom.
TAB = (1176, 662)
# The bear lands in this frame, at 24 per second.
FRAME = 43
SECONDS_AT_MOST = 120


def outside(build, picture):
    build, picture = os.path.abspath(build), os.path.abspath(picture)
    with tempfile.TemporaryDirectory(prefix="fascicle-blender-") as folder:
        environment = dict(os.environ, PATH=build + os.pathsep + os.environ["PATH"], LIBGL_ALWAYS_SOFTWARE="1")
        for name in ("RESOURCES", "SCRIPTS", "CONFIG"):
            environment["BLENDER_USER_" + name] = os.path.join(folder, "user", name.lower())
        subprocess.run(["fascicle", "bake", "jump", "-o", os.path.join(folder, "bear"), "--end", "2.2", "--fps", "24"],
                       check=True, env=environment, stdout=subprocess.DEVNULL)
        # Opening a file prevents Blender's splash screen.
        addon, start = os.path.join(build, "fascicle-blender.zip"), os.path.join(folder, "bear.blend")
        install = ("import bpy; bpy.ops.preferences.addon_install(filepath=%r); "
                   "bpy.ops.wm.save_as_mainfile(filepath=%r)" % (addon, start))
        subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python-expr",
                        install], check=True, env=environment, stdout=subprocess.DEVNULL)
        ran = subprocess.run(["xvfb-run", "-a", "-s", "-screen 0 %dx%dx24" % WINDOW, "blender", "--factory-startup",
                              "--enable-event-simulate", start, "--window-geometry", "0", "0", *map(str, WINDOW),
                              "--python", os.path.abspath(__file__), "--", folder, picture], env=environment,
                             timeout=2 * SECONDS_AT_MOST, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                             check=False)
        if ran.returncode != 0 or not os.path.exists(picture):
            raise SystemExit("blender_picture.py: no picture\n" + ran.stdout)


def inside(folder, picture):
    import time

    import bpy

    steps = iter(())

    def tick():
        try:
            return next(steps)
        except StopIteration:
            bpy.ops.wm.quit_blender()
        except Exception as error:
            print("blender_picture.py:", error)
            os._exit(1)

    def view_area():
        return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")

    def work():
        bpy.ops.preferences.addon_enable(module="fascicle")
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.data.collections.remove(bpy.data.collections["Collection"])
        scene = bpy.context.scene
        scene.render.fps = 24
        bpy.ops.import_scene.gltf(filepath=os.path.join(folder, "bear", "character.glb"), import_shading="SMOOTH")
        armature = next(obj for obj in bpy.data.objects if obj.type == "ARMATURE")
        bpy.context.view_layer.objects.active = armature
        armature.name, armature.animation_data.action.name = "Bear", "Jump"
        next(obj for obj in bpy.data.objects if obj.type == "MESH" and obj.parent == armature).name = "Body"
        armature.fascicle.folder = "//flesh"
        bpy.ops.fascicle.preset(wish="JIGGLE")
        scene.frame_start, scene.frame_end = 0, 48
        armature.fascicle.range = "SCENE"
        area = view_area()
        space = area.spaces[0]
        space.show_region_ui = True
        space.shading.color_type, space.shading.single_color = "SINGLE", (0.72, 0.52, 0.38)
        space.shading.show_shadows = space.shading.show_cavity = True
        space.overlay.show_extras = space.overlay.show_bones = space.overlay.show_cursor = False
        space.show_gizmo_navigate = False
        yield 1.0
        window = bpy.context.window_manager.windows[0]
        # A script cannot select a tab; a click can.
        for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
            window.event_simulate(type=kind, value=value, x=TAB[0], y=TAB[1])
            yield 0.3
        with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
            result = bpy.ops.fascicle.bake("INVOKE_DEFAULT")
        if result != {"RUNNING_MODAL"}:
            raise RuntimeError("the bake does not run in the background: %s" % result)
        state = window.screen and bpy.context.window_manager.fascicle
        begun = time.monotonic()
        while state.is_running:
            if time.monotonic() - begun > SECONDS_AT_MOST:
                raise RuntimeError("the bake does not end: " + state.message)
            yield 0.2
        scene.frame_set(FRAME)
        for obj in scene.objects:
            obj.select_set(False)
        region = area.spaces[0].region_3d
        region.view_perspective = "PERSP"
        region.view_location, region.view_distance = (0.2, 0.0, 0.6), 3.4
        from mathutils import Euler
        region.view_rotation = Euler((1.42, 0.0, 0.75)).to_quaternion()
        yield 2.0
        with bpy.context.temp_override(window=window, area=area):
            bpy.ops.screen.screenshot(filepath=picture)
        yield 0.5

    steps = work()
    bpy.app.timers.register(tick, first_interval=1.0)


if "--" in sys.argv:
    inside(*sys.argv[sys.argv.index("--") + 1:])
else:
    outside(*sys.argv[1:])
