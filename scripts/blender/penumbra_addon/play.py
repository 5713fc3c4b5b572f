"""The result in Blender: a table of frames and vertices as an image, and a geometry-nodes modifier that reads it.

The image is a packed picture of floats, four vertices in a texel: vertex v of row r is channel v mod 4 of the texel
(v div 4) mod W in the line r R + (v div 4) div W, counted from the bottom, where R lines of W texels hold a row. The
modifier takes two rows around the frame and blends them. It needs neither Penumbra nor Python.
"""
import bpy
import numpy as np

from .programs import Failed

MODIFIER = "Penumbra"
DARK = "_dark"  # ends the name of a second attribute, 1 - occlusion: where it is missing, materials read 0, no darkness
MAX_TEXELS = 4096  # in a line of the image
INPUTS = ("First vertex", "Vertices", "First row", "Rows", "First frame", "Step")


def make_image(name, table):
    """The table [F,V] as a packed image of floats."""
    frames, vertices = table.shape
    texels = -(-vertices // 4)
    width = min(texels, MAX_TEXELS)
    lines = -(-texels // width)
    if lines * frames > 65536:
        raise Failed(f"an image does not hold {frames} frames of {vertices} vertices: choose fewer, or a larger step")
    pixels = np.zeros((frames, lines * width * 4), np.float32)
    pixels[:, :vertices] = table
    image = bpy.data.images.new(name, width, lines * frames, alpha=True, float_buffer=True, is_data=True)
    image.alpha_mode = "CHANNEL_PACKED"  # else alpha would be multiplied into the other channels
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


class Nodes:
    """Few words for many nodes. Sockets are outputs; numbers stand for themselves."""

    def __init__(self, tree):
        self.tree = tree

    def add(self, kind, **values):
        node = self.tree.nodes.new(kind)
        for name, value in values.items():
            setattr(node, name, value)
        return node

    def join(self, source, target):
        if isinstance(source, (int, float)):
            target.default_value = source
        else:
            self.tree.links.new(source, target)

    def math(self, operation, *operands):
        node = self.add("ShaderNodeMath", operation=operation)
        for socket, operand in zip(node.inputs, operands):
            self.join(operand, socket)
        return node.outputs[0]


def add_sockets(tree):
    """Sockets of a node group, which Blender 4.0 moved from `inputs` to `interface`."""
    sockets = [("Geometry", "NodeSocketGeometry")] + [(name, "NodeSocketInt") for name in INPUTS]
    if hasattr(tree, "interface"):
        for name, kind in sockets:
            tree.interface.new_socket(name, in_out="INPUT", socket_type=kind)
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        for name, kind in sockets:
            tree.inputs.new(kind, name)
        tree.outputs.new("NodeSocketGeometry", "Geometry")


def input_names(tree):
    """The keys under which a modifier keeps the inputs, by the names of these."""
    if hasattr(tree, "interface"):
        items = [item for item in tree.interface.items_tree if item.item_type == "SOCKET" and item.in_out == "INPUT"]
    else:
        items = tree.inputs
    return {item.name: item.identifier for item in items}


def look_up(nodes, image, row, place):
    """The value of this row at `place`: texel, line and channel of the vertex, and lines a row."""
    texel, line, channel, lines = place
    width, height = image.size
    combine = nodes.add("ShaderNodeCombineXYZ")
    nodes.join(nodes.math("DIVIDE", nodes.math("ADD", texel, 0.5), float(width)), combine.inputs[0])
    line = nodes.math("ADD", nodes.math("MULTIPLY", row, float(lines)), line)
    nodes.join(nodes.math("DIVIDE", nodes.math("ADD", line, 0.5), float(height)), combine.inputs[1])
    texture = nodes.add("GeometryNodeImageTexture", interpolation="Closest", extension="EXTEND")
    texture.inputs["Image"].default_value = image
    nodes.join(combine.outputs[0], texture.inputs["Vector"])
    separate = nodes.add("FunctionNodeSeparateColor")
    nodes.join(texture.outputs["Color"], separate.inputs[0])
    value = 0.0
    for number, output in enumerate([*separate.outputs[:3], texture.outputs["Alpha"]]):
        chosen = nodes.math("COMPARE", channel, float(number), 0.5)
        value = nodes.math("ADD", value, nodes.math("MULTIPLY", chosen, output))
    return value


def rows_of_frame(nodes, inputs):
    """The rows before and after the frame of the scene, within the clip, and the share of the latter."""
    now = nodes.add("GeometryNodeInputSceneTime").outputs["Frame"]
    row = nodes.math("DIVIDE", nodes.math("SUBTRACT", now, inputs["First frame"]), inputs["Step"])
    last = nodes.math("SUBTRACT", inputs["Rows"], 1.0)
    row = nodes.math("MINIMUM", nodes.math("MAXIMUM", row, 0.0), last)
    low = nodes.math("FLOOR", row)
    return low, nodes.math("MINIMUM", nodes.math("ADD", low, 1.0), last), nodes.math("SUBTRACT", row, low)


def place_of_vertex(nodes, inputs, width, lines):
    """Texel, line and channel of a vertex, as look_up wants them."""
    vertex = nodes.math("ADD", nodes.add("GeometryNodeInputIndex").outputs[0], inputs["First vertex"])
    texel = nodes.math("FLOOR", nodes.math("DIVIDE", vertex, 4.0))
    channel = nodes.math("SUBTRACT", vertex, nodes.math("MULTIPLY", texel, 4.0))
    line = nodes.math("FLOOR", nodes.math("DIVIDE", nodes.math("ADD", texel, 0.5), float(width)))
    return nodes.math("SUBTRACT", texel, nodes.math("MULTIPLY", line, float(width))), line, channel, lines


def make_tree(name, image, frames, attribute):
    """The node group. A mesh whose number of vertices has changed since the bake gets 1, which darkens nothing."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    add_sockets(tree)
    nodes = Nodes(tree)
    entry, exit_ = nodes.add("NodeGroupInput"), nodes.add("NodeGroupOutput")
    inputs = entry.outputs
    low, high, share = rows_of_frame(nodes, inputs)
    place = place_of_vertex(nodes, inputs, image.size[0], image.size[1] // frames)
    low, high = (look_up(nodes, image, nodes.math("ADD", r, inputs["First row"]), place) for r in (low, high))
    value = nodes.math("ADD", low, nodes.math("MULTIPLY", share, nodes.math("SUBTRACT", high, low)))
    size = nodes.add("GeometryNodeAttributeDomainSize", component="MESH")
    nodes.join(inputs["Geometry"], size.inputs["Geometry"])
    same = nodes.math("COMPARE", size.outputs["Point Count"], inputs["Vertices"], 0.5)
    value = nodes.math("ADD", nodes.math("MULTIPLY", value, same), nodes.math("SUBTRACT", 1.0, same))
    color = nodes.add("FunctionNodeCombineColor")
    for socket in color.inputs[:3]:
        nodes.join(value, socket)
    store = nodes.add("GeometryNodeStoreNamedAttribute", data_type="FLOAT_COLOR", domain="POINT")
    store.inputs["Name"].default_value = attribute
    nodes.join(inputs["Geometry"], store.inputs["Geometry"])
    nodes.join(color.outputs[0], next(s for s in store.inputs if s.name == "Value" and s.enabled))
    dark = nodes.add("GeometryNodeStoreNamedAttribute", data_type="FLOAT", domain="POINT")
    dark.inputs["Name"].default_value = attribute + DARK
    nodes.join(store.outputs[0], dark.inputs["Geometry"])
    darkness = nodes.math("SUBTRACT", 1.0, value)
    nodes.join(darkness, next(s for s in dark.inputs if s.name == "Value" and s.enabled))
    nodes.join(dark.outputs[0], exit_.inputs[0])
    return tree


def modifier_name(attribute):
    return f"{MODIFIER} {attribute}"


def is_ours(modifier):
    return modifier.type == "NODES" and modifier.name.startswith(MODIFIER + " ")


def detach(things, attribute):
    """Takes the modifier of an earlier result from these objects, and its group and image where nobody else has
    them."""
    for thing in things:
        modifier = thing.modifiers.get(modifier_name(attribute))
        tree = modifier.node_group if modifier else None
        if modifier:
            thing.modifiers.remove(modifier)
        if tree and not tree.users:
            images = {n.inputs["Image"].default_value for n in tree.nodes if n.type == "IMAGE_TEXTURE"}
            bpy.data.node_groups.remove(tree)
            for image in images:
                if image and not image.users:
                    bpy.data.images.remove(image)


def attach(things, counts, table, clips, attribute):
    """Gives every object its modifier, which plays the first of `clips` (name, first row, rows, first frame, step)."""
    detach(things, attribute)
    name = f"{things[0].name} {attribute}"
    image = make_image(name, table)
    tree = make_tree(name, image, len(table), attribute)
    first = 0
    for thing, count in zip(things, counts):
        try:
            modifier = thing.modifiers.new(modifier_name(attribute), "NODES")
        except RuntimeError:
            modifier = None
        if modifier is None:
            raise Failed(f"{thing.name} takes no modifier: make linked data local first")
        modifier.node_group = tree
        names = input_names(tree)
        modifier[names["First vertex"]], modifier[names["Vertices"]] = int(first), int(count)
        first += count
    play(things, attribute, clips[0])


def play(things, attribute, clip):
    """Makes the modifiers show a clip."""
    _, first_row, rows, first_frame, step = clip
    for thing in things:
        modifier = thing.modifiers.get(modifier_name(attribute))
        if not modifier or not modifier.node_group:
            continue
        names = input_names(modifier.node_group)
        for key, value in (("First row", first_row), ("Rows", rows), ("First frame", first_frame), ("Step", step)):
            modifier[names[key]] = int(value)
        thing.update_tag()


NODE = "Penumbra multiply"


def show(things, attribute, wanted):
    """Multiplies the attribute into the base colour of the materials of these objects, or takes that away again."""
    changed = 0
    for material in {slot.material for thing in things for slot in thing.material_slots if slot.material}:
        tree = material.node_tree if material.use_nodes else None
        shader = next((n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"), None) if tree else None
        if shader:
            unhook(tree, shader)
            if wanted:
                hook(tree, shader, attribute)
            changed += 1
    return changed


def show_other(things, before, now):
    """Where the materials of these objects show the attribute `before`, they show `now`."""
    for material in {slot.material for thing in things for slot in thing.material_slots if slot.material}:
        source = material.node_tree.nodes.get(NODE + " by") if material.use_nodes else None
        if source and source.attribute_name == before + DARK:
            source.attribute_name = now + DARK


def unhook_all():
    """Takes the occlusion out of all materials, for exporters that know plain base colours; returns what there was."""
    found = []
    for material in bpy.data.materials:
        tree = material.node_tree if material.use_nodes else None
        multiply = tree.nodes.get(NODE) if tree else None
        if multiply and multiply.outputs[0].links:
            shader, attribute = multiply.outputs[0].links[0].to_node, tree.nodes[NODE + " by"].attribute_name
            unhook(tree, shader)
            found.append((tree, shader, attribute.removesuffix(DARK)))
    return found


def hook_again(found):
    for tree, shader, attribute in found:
        hook(tree, shader, attribute)


def unhook(tree, shader):
    multiply = tree.nodes.get(NODE)
    if not multiply:
        return
    links = multiply.inputs[0].links
    if links:
        tree.links.new(links[0].from_socket, shader.inputs["Base Color"])
    for name in (NODE + " by", NODE + " open", NODE):
        if name in tree.nodes:
            tree.nodes.remove(tree.nodes[name])


def hook(tree, shader, attribute):
    """Multiplies by 1 - darkness. Objects that share the material and were not baked stay as they are."""
    nodes, target = Nodes(tree), shader.inputs["Base Color"]
    multiply = nodes.add("ShaderNodeVectorMath", operation="MULTIPLY", name=NODE, label="occlusion")
    source = nodes.add("ShaderNodeAttribute", attribute_name=attribute + DARK, name=NODE + " by")
    open_ = nodes.add("ShaderNodeMath", operation="SUBTRACT", name=NODE + " open")
    x, y = shader.location
    multiply.location, open_.location, source.location = (x - 200, y - 60), (x - 400, y - 160), (x - 600, y - 160)
    if target.links:
        tree.links.new(target.links[0].from_socket, multiply.inputs[0])
    else:
        multiply.inputs[0].default_value = target.default_value[:3]
    open_.inputs[0].default_value = 1.0
    tree.links.new(source.outputs["Fac"], open_.inputs[1])
    tree.links.new(open_.outputs[0], multiply.inputs[1])
    tree.links.new(multiply.outputs[0], target)
