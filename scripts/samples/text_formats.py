"""One rig, a bent tube, as DirectX .x, Collada and ASCII FBX, each in the units and axes that its tools write."""
import numpy as np

# Our frame (y up, metres) to z up in centimetres: (x, y, z) becomes 100 (x, -z, y).
Z_UP = np.array([[100.0, 0, 0, 0], [0, 0, -100, 0], [0, 100, 0, 0], [0, 0, 0, 1]])
MIRROR = np.diag([1.0, 1, -1, 1])  # ours to DirectX: left-handed


class Bones:
    """Holds points [n,3], triangles [m,3], weights [n,J]; and for each joint its name, parent, rest matrix, and local
    matrices at `times`."""

    def __init__(self, points, triangles, weights, names, parents, times, local, rest):
        self.points, self.triangles, self.weights = points, triangles, weights
        self.names, self.parents, self.times, self.local, self.rest = names, parents, times, local, rest

    def moved(self, space):
        """Returns the same rig in another space."""
        back = np.linalg.inv(space)
        points = self.points @ space[:3, :3].T
        turned = self.triangles if np.linalg.det(space) > 0 else self.triangles[:, ::-1]
        local = [[space @ m @ back for m in keys] for keys in self.local]
        rest = [space @ m @ back for m in self.rest]
        return Bones(points, turned, self.weights, self.names, self.parents, self.times, local, rest)

    def bind(self, j):
        """Returns the transform from joint to model space at rest."""
        return self.rest[j] if self.parents[j] < 0 else self.bind(self.parents[j]) @ self.rest[j]

    def children(self, parent):
        return [j for j in range(len(self.names)) if self.parents[j] == parent]


def numbers(values, separator=" "):
    return separator.join("%.9g" % v for v in np.asarray(values).reshape(-1))


def x_matrix(m):
    # Rows of the matrix for row vectors. ", ": assimp reads "1,0" as a number with a decimal comma.
    return numbers(m.T, ", ") + ";;"


def write_x(bones, path, clip="swing"):
    b = bones.moved(MIRROR)

    def frame(j):
        inner = "".join(frame(c) for c in b.children(j))
        return "Frame %s {\nFrameTransformMatrix { %s }\n%s}\n" % (b.names[j], x_matrix(b.rest[j]), inner)

    points = ",\n".join("%.9g;%.9g;%.9g;" % tuple(p) for p in b.points)
    faces = ",\n".join("3;%d,%d,%d;" % tuple(t) for t in b.triangles)
    skin = "XSkinMeshHeader { 2; 2; %d; }\n" % len(b.names)
    for j, name in enumerate(b.names):
        used = np.flatnonzero(b.weights[:, j])
        skin += 'SkinWeights { "%s"; %d;\n%s;\n%s;\n%s }\n' % (
            name, len(used), ",".join(map(str, used)), numbers(b.weights[used, j], ", "),
            x_matrix(np.linalg.inv(b.bind(j))),
        )  # fmt: skip
    keys = ""
    for j, name in enumerate(b.names):
        rows = ",\n".join("%d;16;%s" % (round(t * 4800), x_matrix(m)) for t, m in zip(b.times, b.local[j]))
        keys += "Animation { { %s }\nAnimationKey { 4; %d;\n%s; } }\n" % (name, len(b.times), rows)
    with open(path, "w") as f:
        f.write("xof 0303txt 0032\nAnimTicksPerSecond { 4800; }\n")
        f.write("".join(frame(j) for j in b.children(-1)))
        mesh = "%d;\n%s;\n%d;\n%s;\n%s" % (len(b.points), points, len(b.triangles), faces, skin)
        f.write("Frame tube {\nMesh {\n%s}\n}\n" % mesh)
        f.write("AnimationSet %s {\n%s}\n" % (clip, keys))


def collada_source(name, values, stride, kind="float", params="XYZ"):
    values = values if kind == "Name" else np.asarray(values)
    count = len(values) if kind == "Name" else values.size
    text = " ".join(values) if kind == "Name" else numbers(values)
    kind_of = "float4x4" if stride == 16 else ("name" if kind == "Name" else "float")
    names = ['<param name="%s" type="%s"/>' % (p, kind_of) for p in (params if stride == 3 else [params])]
    return (
        '<source id="%s"><%s_array id="%s-a" count="%d">%s</%s_array><technique_common><accessor source="#%s-a" '
        'count="%d" stride="%d">%s</accessor></technique_common></source>\n'
        % (name, kind, name, count, text, kind, name, count // stride, stride, "".join(names))
    )


def collada_skin(b):
    joints = collada_source("skin-j", b.names, 1, "Name", "JOINT")
    binds = collada_source("skin-b", [np.linalg.inv(b.bind(j)) for j in range(len(b.names))], 16, params="TRANSFORM")
    used = [np.flatnonzero(row) for row in b.weights]
    pairs, weights = [], []
    for row, of_vertex in zip(b.weights, used):
        for j in of_vertex:
            pairs += [j, len(weights)]
            weights.append(row[j])
    return (
        '<controller id="skin"><skin source="#mesh"><bind_shape_matrix>%s</bind_shape_matrix>\n%s%s%s'
        '<joints><input semantic="JOINT" source="#skin-j"/>'
        '<input semantic="INV_BIND_MATRIX" source="#skin-b"/></joints>\n'
        '<vertex_weights count="%d"><input semantic="JOINT" source="#skin-j" offset="0"/><input semantic="WEIGHT" '
        'source="#skin-w" offset="1"/><vcount>%s</vcount><v>%s</v></vertex_weights></skin></controller>\n'
        % (
            numbers(np.eye(4)), joints, binds, collada_source("skin-w", weights, 1, params="WEIGHT"), len(used),
            " ".join(str(len(u)) for u in used), " ".join(map(str, pairs)),
        )
    )  # fmt: skip


def write_dae(bones, path):
    b = bones.moved(Z_UP)

    def node(j):
        inner = "".join(node(c) for c in b.children(j))
        matrix = '<matrix sid="transform">%s</matrix>' % numbers(b.rest[j])
        return '<node id="%s" name="%s" sid="%s" type="JOINT">%s%s</node>\n' % (*[b.names[j]] * 3, matrix, inner)

    mesh = collada_source("mesh-p", b.points, 3)
    mesh += '<vertices id="mesh-v"><input semantic="POSITION" source="#mesh-p"/></vertices>\n'
    mesh += '<triangles count="%d"><input semantic="VERTEX" source="#mesh-v" offset="0"/><p>%s</p></triangles>\n' % (
        len(b.triangles), " ".join(map(str, b.triangles.reshape(-1)))
    )  # fmt: skip
    tracks = ""
    for j, name in enumerate(b.names):
        tracks += '<animation id="a-%s">%s%s%s' % (
            name, collada_source("t-" + name, b.times, 1, params="TIME"),
            collada_source("m-" + name, b.local[j], 16, params="TRANSFORM"),
            collada_source("i-" + name, ["LINEAR"] * len(b.times), 1, "Name", "INTERPOLATION"),
        )  # fmt: skip
        tracks += (
            '<sampler id="s-%s"><input semantic="INPUT" source="#t-%s"/><input semantic="OUTPUT" source="#m-%s"/>'
            '<input semantic="INTERPOLATION" source="#i-%s"/></sampler>'
            '<channel source="#s-%s" target="%s/transform"/></animation>\n'
            % (*[name] * 6,)
        )
    skeleton = "".join(node(j) for j in b.children(-1))
    roots = "".join("<skeleton>#%s</skeleton>" % b.names[j] for j in b.children(-1))
    with open(path, "w") as f:
        f.write('<?xml version="1.0" encoding="utf-8"?>\n')
        f.write('<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" ')
        f.write('version="1.4.1"><asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>\n')
        f.write('<library_geometries><geometry id="mesh"><mesh>%s</mesh></geometry></library_geometries>\n' % mesh)
        f.write("<library_controllers>%s</library_controllers>\n" % collada_skin(b))
        f.write('<library_animations><animation id="swing">%s</animation></library_animations>\n' % tracks)
        f.write('<library_visual_scenes><visual_scene id="scene">%s' % skeleton)
        f.write('<node id="tube"><instance_controller url="#skin">')
        f.write("%s</instance_controller></node></visual_scene></library_visual_scenes>\n" % roots)
        f.write('<scene><instance_visual_scene url="#scene"/></scene></COLLADA>\n')


def fbx_array(name, values):
    values = np.asarray(values).reshape(-1)
    return "%s: *%d { a: %s }\n" % (name, len(values), numbers(values, ","))


def pre_rotation(b, j):
    """Degrees about our z axis (-y in FBX's space) that joints below the root have before their animated rotation: what
    FBX calls PreRotation, as most tools write it."""
    return np.array([0, -30.0, 0]) if b.parents[j] >= 0 else np.zeros(3)


def euler_xyz(m):
    """Returns degrees (x, y, z) of the rotation Rz Ry Rx, FBX's default order."""
    x, y = np.arctan2(m[2, 1], m[2, 2]), np.arcsin(np.clip(-m[2, 0], -1, 1))
    return np.degrees([x, y, np.arctan2(m[1, 0], m[0, 0])])


def fbx_curves(b, connect, pivot):
    """Writes animation curves of translation and rotation. Object numbers start at 1000."""
    ticks = 46186158000  # a second
    number, text = 1000, ""
    for j in range(len(b.names)):
        # FBX turns about translation + pivot. T P R P^-1 is the matrix that we want for this translation.
        p = pivot if b.parents[j] >= 0 else np.zeros(3)
        moved = lambda m: m[:3, 3] - p + m[:3, :3] @ p
        turned = lambda m: euler_xyz(m) - pre_rotation(b, j)  # about one axis, so that angles add up
        for kind, short, of in (("Translation", "T", moved), ("Rotation", "R", turned)):
            values = np.array([of(m) for m in b.local[j]])
            node, number = number, number + 1
            text += 'AnimationCurveNode: %d, "AnimCurveNode::%s", "" { Properties70: {\n' % (node, short)
            for axis, value in zip("XYZ", values[0]):
                text += 'P: "d|%s", "Number", "", "A",%.9g\n' % (axis, value)
            text += "} }\n"
            connect('"OO",%d,401' % node)
            connect('"OP",%d,%d,"Lcl %s"' % (node, 210 + j, kind))
            for axis, column in zip("XYZ", values.T):
                text += 'AnimationCurve: %d, "AnimCurve::", "" { Default: 0\nKeyVer: 4008\n' % number
                text += "KeyTime: *%d { a: %s }\n" % (len(b.times), ",".join(str(round(t * ticks)) for t in b.times))
                text += fbx_array("KeyValueFloat", column) + "KeyAttrFlags: *1 { a: 24836 }\n"
                text += "KeyAttrDataFloat: *4 { a: 0,0,0,0 }\nKeyAttrRefCount: *1 { a: %d } }\n" % len(b.times)
                connect('"OP",%d,%d,"d|%s"' % (number, node, axis))
                number += 1
    return text


def write_fbx(bones, path, pivot=np.zeros(3)):
    """Writes the rig. `pivot` (FBX space) is the RotationPivot of the joints below the root."""
    b = bones.moved(Z_UP)
    connections = []
    connect = connections.append
    polygons = np.stack([b.triangles[:, 0], b.triangles[:, 1], -b.triangles[:, 2].astype(int) - 1], 1)
    text = 'Geometry: 100, "Geometry::tube", "Mesh" {\n%s%sGeometryVersion: 124\n}\n' % (
        fbx_array("Vertices", b.points), fbx_array("PolygonVertexIndex", polygons)
    )  # fmt: skip
    text += 'Model: 200, "Model::tube", "Mesh" { Version: 232\n}\n'
    text += 'Deformer: 300, "Deformer::skin", "Skin" { Version: 101\n}\n'
    for pair in ("100,200", "200,0", "300,100"):
        connect('"OO",' + pair)
    for j, name in enumerate(b.names):
        translation, rotation = numbers(b.rest[j][:3, 3], ","), numbers(euler_xyz(b.rest[j]) - pre_rotation(b, j), ",")
        text += 'Model: %d, "Model::%s", "LimbNode" { Version: 232\nProperties70: {\n' % (210 + j, name)
        text += 'P: "Lcl Translation", "Lcl Translation", "", "A",%s\n' % translation
        text += 'P: "RotationActive", "bool", "", "",1\nP: "PreRotation", "Vector3D", "Vector", "",%s\n' % numbers(
            pre_rotation(b, j), ","
        )
        if b.parents[j] >= 0 and np.any(pivot):
            text += 'P: "RotationPivot", "Vector3D", "Vector", "",%s\n' % numbers(pivot, ",")
        text += 'P: "Lcl Rotation", "Lcl Rotation", "", "A",%s\n} }\n' % rotation
        used = np.flatnonzero(b.weights[:, j])
        text += 'Deformer: %d, "SubDeformer::%s", "Cluster" { Version: 100\n' % (310 + j, name)
        text += "Indexes: *%d { a: %s }\n" % (len(used), ",".join(map(str, used)))
        text += fbx_array("Weights", b.weights[used, j]) + fbx_array("Transform", np.linalg.inv(b.bind(j)).T)
        text += fbx_array("TransformLink", b.bind(j).T) + "}\n"
        connect('"OO",%d,%d' % (210 + j, 210 + b.parents[j] if b.parents[j] >= 0 else 0))
        connect('"OO",%d,300' % (310 + j))
        connect('"OO",%d,%d' % (210 + j, 310 + j))
    text += 'AnimationStack: 400, "AnimStack::swing", "" {\n}\nAnimationLayer: 401, "AnimLayer::base", "" {\n}\n'
    connect('"OO",401,400')
    text += fbx_curves(b, connect, np.asarray(pivot, float))
    axes = {"UpAxis": 2, "UpAxisSign": 1, "FrontAxis": 1, "FrontAxisSign": -1, "CoordAxis": 0, "CoordAxisSign": 1}
    with open(path, "w") as f:
        f.write("; FBX 7.4.0 project file\nFBXHeaderExtension: { FBXHeaderVersion: 1003\nFBXVersion: 7400\n}\n")
        f.write("GlobalSettings: { Version: 1000\nProperties70: {\n")
        for name, value in axes.items():
            f.write('P: "%s", "int", "Integer", "",%d\n' % (name, value))
        f.write('P: "UnitScaleFactor", "double", "Number", "",1\n} }\n')
        f.write("Objects: {\n%s}\nConnections: {\n%s\n}\n" % (text, "\n".join("C: " + c for c in connections)))
