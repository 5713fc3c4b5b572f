"""Which objects are the character, what casts on it, and what is left out."""
from dataclasses import dataclass, field

from .programs import Failed

KEY = "penumbra_role"  # custom property of an object or a collection, for files that are made by scripts
WORDS = {"character": "CHARACTER", "part": "CHARACTER", "occluder": "OCCLUDER", "without": "WITHOUT"}


@dataclass
class Members:
    character: object  # armature, or the mesh itself
    meshes: list = field(default_factory=list)
    occluders: list = field(default_factory=list)
    without: list = field(default_factory=list)

    @property
    def armature(self):
        return self.character if self.character.type == "ARMATURE" else None


def character_of(thing):
    """The object that has the settings: the armature that moves `thing`, or the mesh itself; None of other objects."""
    if thing is None or thing.type == "ARMATURE":
        return thing
    if thing.type != "MESH":
        return None
    mover = thing
    while mover is not None and mover.type != "ARMATURE":
        mover = mover.find_armature() or mover.parent
    return mover or thing


def own_role(holder):
    """The role that an object or a collection has: by the panel, else by the custom property."""
    if holder.penumbra.role != "AUTO":
        return holder.penumbra.role
    word = holder.get(KEY)
    if word is None:
        return "AUTO"
    if str(word).lower() not in WORDS:
        raise Failed(f"{holder.name}: {KEY} is '{word}'; it can be {', '.join(WORDS)}")
    return WORDS[str(word).lower()]


def role_of(thing, collections):
    """An object's own role goes before those of its collections, and a nearer collection before one that holds it."""
    role = own_role(thing)
    for collection in collections if role == "AUTO" else ():
        role = own_role(collection)
        if role != "AUTO":
            break
    return role


def collections_of(scene):
    """Returns the collections of every object, the innermost first."""
    found = {}

    def visit(collection, above):
        chain = [collection, *above]
        for thing in collection.objects:
            found.setdefault(thing.name, []).extend(c for c in chain if c not in found.get(thing.name, []))
        for child in collection.children:
            visit(child, chain)

    for child in scene.collection.children:
        visit(child, [])
    return found


def members(scene, character):
    """Meshes that are seen in the viewport, by name, so that the order of vertices is the same in every run."""
    if character is None:
        raise Failed("choose an armature, or a mesh of the character")
    result, of = Members(character), collections_of(scene)
    for thing in sorted(scene.objects, key=lambda o: o.name):
        if thing.type != "MESH" or not thing.visible_get():
            continue
        role = role_of(thing, of.get(thing.name, ()))
        if role == "AUTO" and character_of(thing) == character or role == "CHARACTER":
            result.meshes.append(thing)
        elif role == "OCCLUDER":
            result.occluders.append(thing)
        elif role == "WITHOUT" and character_of(thing) == character:
            result.without.append(thing)
    editing = [thing.name for thing in [character, *result.meshes, *result.occluders] if thing.mode == "EDIT"]
    if editing:
        raise Failed(f"{editing[0]} is in edit mode: leave it first")
    if not result.meshes:
        raise Failed(f"{character.name} moves no mesh that is seen in the viewport")
    return result
