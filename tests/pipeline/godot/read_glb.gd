# Writes the vertices of imported .glb files as JSON: for each surface positions, colours and the names of its morph
# targets. Godot 3: godot3-server --path PROJECT -s read_glb.gd NAME.glb...
extends SceneTree

func surfaces_of(node, out):
    if node is MeshInstance and node.mesh:
        for s in node.mesh.get_surface_count():
            var arrays = node.mesh.surface_get_arrays(s)
            var positions = []
            var colors = []
            for p in arrays[Mesh.ARRAY_VERTEX]:
                positions.append([p.x, p.y, p.z])
            if arrays[Mesh.ARRAY_COLOR] != null:
                for c in arrays[Mesh.ARRAY_COLOR]:
                    colors.append([c.r, c.g, c.b, c.a])
            out.append({"positions": positions, "colors": colors, "targets": node.mesh.get_blend_shape_count()})
    for child in node.get_children():
        surfaces_of(child, out)

func _init():
    for name in OS.get_cmdline_args():
        if name.ends_with(".glb"):
            var out = []
            surfaces_of(load("res://" + name).instance(), out)
            var file = File.new()
            file.open("res://" + name + ".json", File.WRITE)
            file.store_string(to_json(out))
            file.close()
    quit()
