"""What moves in the scene `courtyard in motion`: the sun, cloth, a figure that carries a lamp, a crate and a camera."""

import math
import struct

from . import cloth, props
from . import layout as L
from .gltf import look, yaw
from .mesh import Mesh, add, normalize, sub

SECONDS = 8.0
# Nodes of the still scene that moving ones stand in for, by their names.
REPLACED = ("sun", "blue awning", "ochre awning", "red awning")
SUN_COLOR, SUN = (1.0, 0.93, 0.82), 16.0
LAMP_COLOR, LAMP = (1.0, 0.55, 0.2), 14.0
# The middle of the sun's way, where it is at rest, and the horizontal axis across it.
NOON = normalize((-0.42, 1.0, -0.54))
EAST = normalize((0.54, 0.0, -0.42))
# Half a degree a frame at 24 frames a second.
SUN_DEGREES = 96.0
# The figure walks along the sunny arcade, a metre a second, with so many steps a second.
WALK_Z, WALK_FROM_X, STEPS = L.HALF_Z + 1.5, -4.0, 1.25


def moments(count, seconds=SECONDS):
    """Evenly spaced, the first and the last included."""
    return [seconds * i / count for i in range(count + 1)]


def turn(axis, degrees):
    """Quaternion of a turn about an axis."""
    a = math.radians(degrees) / 2.0
    return (*(math.sin(a) * c for c in axis), math.cos(a))


def waving(mesh, moved):
    """The offsets of positions and normals from a mesh to another with the same topology."""
    base, other = mesh.buffers(), moved.buffers()
    if [len(data) for data in base] != [len(data) for data in other]:
        raise ValueError("the shapes of a cloth have different vertices")

    def offsets(kind):
        pairs = zip(struct.iter_unpack("<3f", base[kind]), struct.iter_unpack("<3f", other[kind]))
        return [sub(b, a) for a, b in pairs]
    return offsets(0), offsets(1)


def bent(mesh, offset):
    """A sheet with every point moved by `offset(position)`, and the normals that follow from its neighbours'."""
    result, step = Mesh(0.25), 1e-3
    result.indices = mesh.indices
    for vertex in mesh.vertices:
        p, n = vertex[:3], normalize(vertex[3:6])
        side = normalize((n[2], 0.0, -n[0]) if abs(n[1]) < 0.9 else (1.0, 0.0, 0.0))
        side = normalize(sub(side, tuple(c * sum(a * b for a, b in zip(side, n)) for c in n)))
        up = (n[1] * side[2] - n[2] * side[1], n[2] * side[0] - n[0] * side[2], n[0] * side[1] - n[1] * side[0])
        at = [add(q, offset(q)) for q in (p, add(p, side, step), add(p, up, step))]
        a, b = sub(at[1], at[0]), sub(at[2], at[0])
        normal = normalize((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))
        result.vertices.append((*at[0], *normal, *vertex[6:]))
    return result


def awnings(doc, mats):
    """The strips over the court, which the wind lifts and ripples; returns their nodes."""
    span, nodes = 2 * L.HALF_Z - 0.2, []
    strips = (cloth.awning(span, 0.75, 0.6, 0.9), cloth.awning(span, 1.25, 0.85, 0.4),
              cloth.awning(span, 1.25, 0.85, 2.1))
    for strip, x, color in zip(strips, (1.4, 3.0, 4.7), ("blue", "ochre", "red")):
        def lifted(p):
            return (0.0, 0.55 * (1.0 - (2.0 * p[2] / span) ** 2), 0.0)

        def rippled(phase):
            def offset(p):
                arc = 1.0 - (2.0 * p[2] / span) ** 2
                return (0.0, 0.16 * arc * math.sin(2.2 * p[2] + 0.8 * p[0] + phase), 0.0)
            return offset
        shapes = [waving(strip, bent(strip, offset))
                  for offset in (lifted, rippled(0.0), rippled(math.pi / 2))]
        nodes.append(doc.morphed(f"{color} awning in the wind", strip, mats[color], shapes, (x, 6.15, 0.0)))
    return nodes


def wind(phase):
    """Weights of an awning's shapes: a gust, and ripples that run along it."""
    values = []
    for t in moments(48):
        turn_of = 2.0 * math.pi * t / SECONDS
        gust = 0.35 - 0.35 * math.cos(2.0 * turn_of + phase)
        values += [gust, math.cos(6.0 * turn_of + phase), math.sin(6.0 * turn_of + phase)]
    return values


def robe():
    """A hooded figure, from the ground up."""
    mesh = Mesh(0.25)
    mesh.lathe([(0.36, 0.02), (0.33, 0.2), (0.29, 0.45), (0.25, 0.75), (0.23, 1.0), (0.22, 1.2), (0.2, 1.33),
                (0.13, 1.42), (0.12, 1.48), (0.15, 1.56), (0.155, 1.66), (0.12, 1.76), (0.0, 1.82)], 20)
    return mesh


def figure(doc, mats):
    """The figure, bent by three joints, with a lantern and its light; the nodes that carry and bend it."""
    heights = (0.0, 0.9, 1.5)
    joints = [doc.node(f"figure's {name}", translation=(0.0, y, 0.0))
              for name, y in zip(("hem", "waist", "hood"), heights)]
    lamp = doc.node("carried lamp", translation=(0.0, -0.85, 0.0),
                    extensions={"KHR_lights_punctual": {"light": doc.light("lamp", "point", LAMP_COLOR, 0.0)}})
    lantern = doc.node("carried lantern", mesh=doc.mesh("carried lantern", [(props.lantern(0.1), mats["brass"])]),
                       translation=(0.55, 1.3, -0.1), scale=[0.6] * 3, children=[lamp])
    root = doc.node("figure", translation=(WALK_FROM_X, L.FLOOR, WALK_Z), rotation=yaw(0),
                    children=[*joints, lantern])

    def weights(y):
        for low, (a, b) in enumerate(zip(heights, heights[1:])):
            if y < b:
                t = max(0.0, (y - a) / (b - a))
                return [(low, 1.0 - t), (low + 1, t)]
        return [(2, 1.0)]
    mesh = robe()
    skin = doc.skin(joints, [(0.0, y, 0.0) for y in heights], root)
    doc.skinned("robe", mesh, mats["blue"], [weights(v[1]) for v in mesh.vertices], skin)
    return root, joints


def walk(doc, root, joints):
    """Channels of a figure that walks, its hem and hood swaying."""
    times = moments(64)
    swing = [2.0 * math.pi * STEPS * t for t in times]
    places = [(WALK_FROM_X + t, L.FLOOR + 0.03 * abs(math.sin(s)), WALK_Z) for t, s in zip(times, swing)]
    return [
        doc.channel(times, places, "VEC3", node=root, path="translation"),
        doc.channel(times, [turn((0, 0, 1), 9.0 * math.sin(s)) for s in swing], "VEC4", node=joints[0], path="rotation"),
        doc.channel(times, [turn((1, 0, 0), 4.0 * math.sin(s)) for s in swing], "VEC4", node=joints[1], path="rotation"),
        doc.channel(times, [turn((0, 1, 0), 25.0 * math.sin(0.25 * s)) for s in swing], "VEC4", node=joints[2],
                    path="rotation"),
    ]


def sun_way():
    """Moments, rotations of the sun's node, and how low it stands, 0 to 1."""
    times, turns, low = moments(24), [], []
    for t in times:
        angle = math.radians(90.0 + SUN_DEGREES * (t / SECONDS - 0.5))
        towards = tuple(math.cos(angle) * e + math.sin(angle) * n for e, n in zip(EAST, NOON))
        turns.append(look(tuple(-c for c in towards)))
        low.append(1.0 - math.sin(angle))
    return times, turns, [value / max(low) for value in low]


def build(doc, mats):
    """Adds the scene `courtyard in motion` and its animations to the document of the still one."""
    doc.begin_second_scene("courtyard in motion", REPLACED)
    light = doc.light("moving sun", "directional", SUN_COLOR, SUN)
    sun = doc.node("moving sun", rotation=look(tuple(-c for c in NOON)),
                   extensions={"KHR_lights_punctual": {"light": light}})
    cloths = awnings(doc, mats)
    root, joints = figure(doc, mats)
    lamp = light + 1
    crate_at = [(4.3, 3.0, -1.4), (-1.2, 2.6, 1.6), (4.3, 3.0, -1.4)]
    crate = doc.node("hoisted crate", mesh=doc.mesh("hoisted crate", [(props.crate(0.6), mats["wood"])]),
                     translation=crate_at[0])
    eyes = [(-5.6, 1.65, -1.0), (-4.6, 1.9, 1.2), (-3.0, 2.3, 2.2)]
    looks = [look(sub((1.5, 2.3, 1.6), eye)) for eye in eyes]
    camera = doc.camera_node("walk", eyes[0], looks[0], 58.0)

    times, turns, low = sun_way()
    lamp_path = f"/extensions/KHR_lights_punctual/lights/{lamp}/intensity"
    sun_path = f"/extensions/KHR_lights_punctual/lights/{light}/"
    warm = [(SUN_COLOR[0], SUN_COLOR[1] - 0.2 * k, SUN_COLOR[2] - 0.35 * k) for k in low]
    ends, middle = [0.0, SECONDS], [0.0, SECONDS / 2.0, SECONDS]

    def sun_turns():
        return doc.channel(times, turns, "VEC4", node=sun, path="rotation")

    def in_the_wind():
        return [doc.channel(moments(48), wind(2.0 * i), "SCALAR", node=node, path="weights")
                for i, node in enumerate(cloths)]

    def shines(seconds, values):
        return doc.channel(seconds, values, "SCALAR", pointer=lamp_path, between="STEP")

    doc.animation("day", [
        sun_turns(), *in_the_wind(), *walk(doc, root, joints), shines(ends, [LAMP, LAMP]),
        doc.channel(times, warm, "VEC3", pointer=sun_path + "color"),
        doc.channel(times, [SUN * (1.0 - 0.3 * k) for k in low], "SCALAR", pointer=sun_path + "intensity")])
    doc.animation("sun", [sun_turns()])
    doc.animation("object", [doc.channel(middle, crate_at, "VEC3", node=crate, path="translation")])
    doc.animation("figure", [*walk(doc, root, joints), *in_the_wind()])
    doc.animation("camera", [doc.channel(middle, eyes, "VEC3", node=camera, path="translation"),
                             doc.channel(middle, looks, "VEC4", node=camera, path="rotation")])
    doc.animation("switch", [shines([0.0, 1.0, SECONDS], [0.0, 4.0 * LAMP, 4.0 * LAMP])])
