"""Puts the courtyard together: materials, building, furnishing, sun and cameras."""

from . import architecture, cloth, foliage, motion, props, textures
from . import layout as L
from .gltf import Document, yaw
from .noise import Rng

COPYRIGHT = "The gridlight maintainers. MIT OR Apache-2.0"
CLOTHS = {"red": (0.62, 0.05, 0.035), "ochre": (0.68, 0.36, 0.05), "green": (0.05, 0.36, 0.12),
          "blue": (0.04, 0.13, 0.52)}


def materials(doc):
    """All materials by short name."""
    ashlar, ashlar_n = textures.ashlar()
    paving, paving_n = textures.paving()
    tex = {name: doc.texture(name, data) for name, data in (
        ("ashlar", ashlar), ("ashlar normal", ashlar_n), ("paving", paving),
        ("paving normal", paving_n), ("limestone", textures.limestone()),
        ("plaster", textures.plaster()), ("checker", textures.checker()),
        ("zellige", textures.zellige()), ("pool", textures.pool()),
        ("terracotta", textures.terracotta()), ("wood", textures.wood()),
        ("weave", textures.weave()), ("rug", textures.rug()), ("spray", textures.leaf_spray()),
        ("ivy", textures.ivy()), ("frond", textures.frond()))}
    mats = {
        "ashlar": doc.material("ashlar", texture=tex["ashlar"], normal=tex["ashlar normal"]),
        "paving": doc.material("paving", texture=tex["paving"], normal=tex["paving normal"]),
        "stone": doc.material("limestone", texture=tex["limestone"]),
        "wood": doc.material("wood", texture=tex["wood"]),
        "brass": doc.material("brass", (0.42, 0.27, 0.1)),
        "soil": doc.material("soil", (0.2, 0.13, 0.08), tex["terracotta"]),
        "glaze": doc.material("blue glaze", (0.1, 0.3, 0.5)),
        "fruit": doc.material("orange", (0.7, 0.27, 0.03)),
    }
    for name in ("plaster", "checker", "zellige", "pool", "terracotta", "rug"):
        mats[name] = doc.material(name, texture=tex[name])
    for name, color in CLOTHS.items():
        mats[name] = doc.material(f"{name} cloth", color, tex["weave"], two_sided=True)
    for name in ("spray", "ivy", "frond"):
        mats[name] = doc.material(f"{name} leaves", texture=tex[name], mask=True, two_sided=True)
    return mats


def hangings(doc, mats):
    """Awnings over the court, banners on the balustrade, curtains, cloth in the arcades."""
    span = 2 * L.HALF_Z - 0.2
    strips = (cloth.awning(span, 0.75, 0.6, 0.9), cloth.awning(span, 1.25, 0.85, 0.4),
              cloth.awning(span, 1.25, 0.85, 2.1))
    for strip, x, color in zip(strips, (1.4, 3.0, 4.7), ("blue", "ochre", "red")):
        doc.place(f"{color} awning", [(strip, mats[color])], (x, 6.15, 0.0))
    rail = [cloth.draped(0.92, 1.25, p) for p in (0.3, 1.7)]
    # (side, position along it, colour): cloth thrown over the balustrade.
    for i, (side, along, color) in enumerate((
            (0, -4.2, "green"), (0, -0.6, "red"), (0, 3.0, "blue"), (0, 4.2, "ochre"),
            (1, -1.8, "red"), (1, 1.8, "green"), (2, 1.8, "ochre"), (2, -3.0, "blue"),
            (3, 0.6, "red"))):
        doc.place(f"{color} drape", [(rail[i % 2], mats[color])],
                  architecture.on_side(side, along, 0.0, L.GALLERY + 0.99), yaw(90 * side))
    # Narrow cloths beside the columns of the sunny arcade, where the sun still reaches them,
    # and wide ones across the shaded arcade.
    narrow = [cloth.banner(1.15, 2.0, p, 2.5, 0.06) for p in (0.0, 1.3)]
    for i, (x, color) in enumerate(((-1.2, "red"), (1.2, "ochre"), (3.6, "green"))):
        doc.place(f"{color} hanging", [(narrow[i % 2], mats[color])],
                  (x, 2.72, L.HALF_Z + 0.92), yaw(90))
    wide = cloth.banner(1.9, 1.5, 0.6, 3.5, 0.07)
    for x, color in ((-3.6, "blue"), (1.2, "red")):
        doc.place(f"{color} hanging", [(wide, mats[color])],
                  (x, L.CEILING - 0.28, -L.HALF_Z - 1.5), yaw(90))
    # Curtains in arches.
    drawn = cloth.curtain(1.7, 2.75, 0.58, 0.7)
    for side, along, color, flip in ((3, 2.4, "ochre", 1),
                                     (0, 2.4, "red", 0), (2, 2.4, "green", 1),
                                     (1, 0.0, "blue", 0)):
        s = -0.86 if not flip else 0.86
        doc.place(f"{color} curtain", [(drawn, mats[color])],
                  architecture.on_side(side, along + s, 0.0, L.SPRING + 0.28),
                  yaw(90 * side + 180 * flip))


def plants(doc, mats):
    """Pots with shrubs and ferns, two orange trees, ivy."""
    clay, soil = props.pot(0.36, 0.55)
    shrubs = [foliage.bush(301, 60, 0.36, 0.85, 0.32), foliage.fern(302, 20, 1.05)]
    kinds = [(shrubs[0], mats["spray"]), (shrubs[1], mats["frond"])]
    pot_parts = [(clay, mats["terracotta"]), (soil, mats["soil"])]
    spots = ((-4.95, 0.0, 2.5, 1), (-3.3, 0.0, 2.75, 0), (-0.9, 0.0, 2.8, 1), (1.5, 0.0, 2.75, 0),
             (5.0, 0.0, 2.5, 1), (5.05, 0.0, 0.9, 0), (5.0, 0.0, -0.9, 0), (0.0, 0.0, -2.8, 0),
             (-1.4, 0.0, -2.8, 1), (-7.9, L.FLOOR, -5.5, 1), (8.2, L.FLOOR, 5.7, 1),
             (8.3, L.FLOOR, 0.0, 1), (-1.2, L.FLOOR, 6.05, 0), (2.4, L.FLOOR, 6.0, 1))
    for i, (x, y, z, kind) in enumerate(spots):
        turn, size = yaw(47 * i % 360), (0.9, 1.0, 1.12)[i % 3]
        doc.place("pot", pot_parts, (x, y, z), turn, size)
        doc.place("plant", [kinds[kind]], (x, y + 0.46 * size, z), turn, size)
    crown = foliage.bush(303, 190, 0.85, 1.5, 0.42)
    trunk, fruit, rng = props.trunk(1.7), props.ball(0.045), Rng(304)
    for x, z in ((3.6, -2.0), (-3.0, -2.3)):
        doc.place("pot", pot_parts, (x, 0.0, z), None, 1.35)
        doc.place("trunk", [(trunk, mats["wood"])], (x, 0.6, z))
        doc.place("tree", [(crown, mats["spray"])], (x, 1.75, z), yaw(40 * x))
        for _ in range(11):
            d = rng.unit()
            doc.place("orange", [(fruit, mats["fruit"])],
                      (x + 0.8 * d[0], 2.5 + 0.65 * d[1], z + 0.8 * d[2]))
    mats_of = foliage.ivy(305, 150, 1.5, 1.9), foliage.ivy(306, 110, 1.0, 1.3)
    for side, along, y, kind in ((0, -2.4, 5.25, 0), (0, 1.5, 5.25, 1), (1, -0.3, 5.25, 0),
                                 (2, 0.0, 5.25, 0), (2, -4.6, 5.25, 1), (3, -2.4, 5.25, 1)):
        doc.place("ivy", [(mats_of[kind], mats["ivy"])],
                  architecture.on_side(side, along, -0.52 if y < 5 else -0.16, y),
                  yaw(90 * side + 180))


def furnishing(doc, mats):
    """Fountain, jars, crates, benches, lanterns, rug."""
    stone, mosaic, pool = props.fountain()
    doc.place("fountain", [(stone, mats["stone"]), (mosaic, mats["zellige"]),
                           (pool, mats["pool"])])
    jar, crate, bench = props.jar(0.95), props.crate(0.6), props.bench(1.7)
    for x, z, size, mat in ((-6.9, -3.1, 1.0, "glaze"), (-7.4, -2.75, 0.75, "terracotta"),
                            (6.9, 5.9, 1.1, "terracotta"), (7.5, 6.05, 0.8, "glaze"),
                            (-0.55, 6.1, 0.9, "glaze"), (5.3, -2.9, 0.0, "")):
        if size:
            doc.place("jar", [(jar, mats[mat])], (x, L.FLOOR, z), yaw(70 * x), size)
    for x, y, z, turn, size in ((-8.2, 0, 3.0, 10, 1.0), (-8.25, 0.6, 3.05, 32, 0.75),
                                (-8.3, 0, 3.9, -8, 0.85), (4.6, 0, -5.9, 20, 1.0)):
        doc.place("crate", [(crate, mats["wood"])], (x, L.FLOOR + y, z), yaw(turn), size)
    for side, along in ((0, 0.0), (0, 4.8), (2, 0.0), (2, -2.4), (1, 2.4), (3, 0.0)):
        doc.place("bench", [(bench, mats["stone"])],
                  architecture.on_side(side, along, L.DEPTH - 0.45, L.FLOOR), yaw(90 * side))
    lamp = props.lantern(0.55)
    for side in range(4):
        for along in architecture.bay_positions(side)[::2]:
            doc.place("lantern", [(lamp, mats["brass"])],
                      architecture.on_side(side, along, 1.5, L.CEILING), yaw(90 * side))
    rug = props.plate(0.75, 1.5, 0.015)
    for x, d in ((-2.2, 1.35), (2.6, 1.35), (-7.4, 0.0)):
        if d:
            doc.place("rug", [(rug, mats["rug"])], (x, L.FLOOR, L.HALF_Z + d), yaw(90))
        else:
            doc.place("rug", [(rug, mats["rug"])], (x, L.FLOOR, 0.6))


def build():
    """The bytes of `courtyard.glb` and the number of triangles of the still scene."""
    doc = Document()
    mats = materials(doc)
    doc.camera("court", (-7.75, 1.65, -1.0), (0.2, 2.7, 1.6), 58.0)
    doc.camera("arcade", (-5.3, 1.6, 5.55), (2.0, 1.95, 4.4), 58.0)
    doc.sun("sun", (0.42, -1.0, 0.54), (1.0, 0.93, 0.82), 16.0)
    architecture.floors(doc, mats)
    architecture.outer_walls(doc, mats)
    architecture.arcades(doc, mats)
    architecture.blind_arcade(doc, mats)
    architecture.gallery(doc, mats)
    architecture.beams(doc, mats)
    architecture.roof(doc, mats)
    hangings(doc, mats)
    plants(doc, mats)
    furnishing(doc, mats)
    motion.build(doc, mats)
    return doc.glb(COPYRIGHT), doc.triangles
