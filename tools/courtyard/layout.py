"""Shared measures in metres. The court's column lines form a rectangle around the origin.

Distances `d` are measured outwards from that rectangle, in the arcade's depth.
"""

HALF_X, HALF_Z = 6.0, 3.6  # column lines
BAY = 2.4  # between column axes on the ground floor
BAYS_X, BAYS_Z = 5, 3
WALL = 0.5  # thickness of the arcade walls
DEPTH = 3.0  # column line to inner face of the outer wall
OUTER = 3.4  # column line to outer face of the outer wall

FLOOR = 0.15  # arcade floor; the court's is 0
SPRING = 2.75  # springing of the ground-floor arches
CEILING = 4.05  # underside of the gallery slab
GALLERY = 4.3  # gallery floor
UPPER_SPRING = 6.0  # springing of the gallery arches
UPPER_CEILING = 6.85
EAVE, RIDGE = 7.25, 8.0  # top of the roof slab at the court and at the outer wall
PARAPET = 8.4
