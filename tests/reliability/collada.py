"""A small character as Collada, which fascicle-convert reads."""

UNIT = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"
# A spindle along y: rings of four corners, closed at both ends.
RINGS = [(0.0, 0.2), (0.5, 0.3), (1.0, 0.3), (1.5, 0.2)]


def source(name, values, stride, parameter, kind="float"):
    word = "Name_array" if kind == "name" else "float_array"
    return ('<source id="{0}"><{1} id="{0}-array" count="{2}">{3}</{1}><technique_common><accessor source="#{0}-array" '
            'count="{4}" stride="{5}">{6}</accessor></technique_common></source>\n').format(
                name, word, len(values), " ".join(str(value) for value in values), len(values) // stride, stride,
                "".join('<param name="%s" type="%s"/>' % (letter, kind) for letter in parameter))


def matrices(name, count):
    return source(name, UNIT.split() * count, 16, ["TRANSFORM"], "float4x4")


def write(path):
    """One joint, one clip of 2 s in which it stands still."""
    points = [value for y, r in RINGS for x, z in ((r, 0), (0, -r), (-r, 0), (0, r)) for value in (x, y, z)]
    corners = [0, 3, 2, 0, 2, 1]
    for ring in range(len(RINGS) - 1):
        for k in range(4):
            a, b = 4 * ring + k, 4 * ring + (k + 1) % 4
            corners += [a, b, b + 4, a, b + 4, a + 4]
    top = 4 * (len(RINGS) - 1)
    corners += [top, top + 1, top + 2, top, top + 2, top + 3]
    vertices = len(points) // 3

    def used(semantic, name, more=""):
        return '<input semantic="%s" source="#%s"%s/>' % (semantic, name, more)

    text = (
        '<?xml version="1.0"?>\n<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">\n'
        '<asset><unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>\n'
        '<library_geometries><geometry id="spindle" name="spindle"><mesh>\n' + source("places", points, 3, "XYZ") +
        '<vertices id="corners">' + used("POSITION", "places") + '</vertices>\n<triangles count="%d">' % (
            len(corners) // 3) + used("VERTEX", "corners", ' offset="0"') +
        "<p>" + " ".join(map(str, corners)) + "</p></triangles>\n</mesh></geometry></library_geometries>\n"
        '<library_controllers><controller id="skin"><skin source="#spindle"><bind_shape_matrix>' + UNIT +
        "</bind_shape_matrix>\n" + source("joints", ["bone"], 1, ["JOINT"], "name") + matrices("binds", 1) +
        source("weights", [1], 1, "W") + "<joints>" + used("JOINT", "joints") + used("INV_BIND_MATRIX", "binds") +
        '</joints>\n<vertex_weights count="%d">' % vertices + used("JOINT", "joints", ' offset="0"') +
        used("WEIGHT", "weights", ' offset="1"') + "<vcount>" + "1 " * vertices + "</vcount><v>" + "0 0 " * vertices +
        "</v></vertex_weights>\n</skin></controller></library_controllers>\n"
        '<library_animations><animation id="still">\n' + source("times", [0, 2], 1, "T") + matrices("turns", 2) +
        source("ways", ["LINEAR", "LINEAR"], 1, ["INTERPOLATION"], "name") + '<sampler id="sampler">' +
        used("INPUT", "times") + used("OUTPUT", "turns") + used("INTERPOLATION", "ways") +
        '</sampler>\n<channel source="#sampler" target="bone/transform"/></animation></library_animations>\n'
        '<library_visual_scenes><visual_scene id="scene" name="scene">\n<node id="bone" sid="bone" name="bone" '
        'type="JOINT"><matrix sid="transform">' + UNIT + '</matrix></node>\n<node id="body" name="body">'
        '<instance_controller url="#skin"><skeleton>#bone</skeleton></instance_controller></node>\n</visual_scene>'
        '</library_visual_scenes>\n<scene><instance_visual_scene url="#scene"/></scene></COLLADA>\n')
    with open(path, "w") as file:
        file.write(text)
