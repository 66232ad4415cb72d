"""Numbers of Lin and Yuksel 2019: an RTX 2080 at 1280x720, in Sponza; milliseconds."""
DEVICE = "RTX 2080"
VPLS = (1_000, 10_000, 100_000, 1_000_000)

# Table 1, 100k VPLs: (scatter from the VPLs, gather from S1).
CONSTRUCTION = {
    "Bounds": (1.7, 1.7), "S1": (2.3, 2.3), "S2": (2.3, 1.0), "S3": (4.7, 1.0), "S4": (23, 2.0), "S5": (107, 1.0),
    "S6": (405, 1.1), "S7": (1563, 1.5), "Merge": (0.5, 0.5), "Total": (2110, 12.1)}

# Table 2, one value for each of VPLS.
VPL_GENERATION = (0.1, 0.2, 0.4, 2.5)
HIERARCHY = (7.0, 9.2, 12.1, 32.0)
RENDER = {0: (5.6, 8.1, 11.2, 16.0), 1: (10.1, 14.3, 18.4, 24.3), 4: (15.5, 22.4, 28.5, 37.0)}

# Table 3, 100k VPLs, four shadow samples, alpha 1: (no interleaving, 2x2, 4x4).
RENDERING = {
    "G-buffer": (1.1, 1.1, 1.0), "Lighting": (24.8, 9.0, 3.8), "Shadow rays": (2.3, 2.2, 2.2),
    "Shadow filter": (1.9, 2.8, 2.9), "Composite": (0.1, 0.1, 0.1), "Total": (30.2, 15.2, 10.1)}

# Harada 2014, Figure 5 and Table 1, 500k points at 1280x720.
PBGI_DEVICE = "Radeon R9 290X"
# Primary points, secondary ones seen (where the text has them), those that are lit; milliseconds of a frame.
PBGI = {"Primitives": (11_720, 25_280, 8_040, 40.0), "Teapots": (11_450, None, 5_730, 34.4),
        "Dragons": (15_520, None, 9_140, 42.97), "Castle": (11_720, None, 19_320, 44.09)}
