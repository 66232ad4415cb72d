"""Which passes make up the rows of the paper's tables. Every pass of a frame belongs to exactly one row."""
import dataclasses
import re

from .errors import BenchError

VPLS, CONSTRUCTION, RENDER = "VPL generation", "Hierarchy construction", "Rendering"
TOP_LEVEL = 10


@dataclasses.dataclass(frozen=True)
class Row:
    phase: str
    title: str
    pattern: str


ROWS = [
    Row(VPLS, "VPL generation", r"vpl_trace(/.*)?|exclusive_scan/vpls/.*|compaction/compact_vpls"),
    Row(CONSTRUCTION, "Bounds", r"bounds(/.*)?"),
    # The paper has no such step. One row for all levels: with --build scatter they are marked and listed together.
    Row(CONSTRUCTION, "Occupied vertices", r"compaction/(?!compact_vpls$).*|exclusive_scan/(?!(vpls|cells|light_buckets)/).*"),
    Row(CONSTRUCTION, "S1",
        r"grid_scatter/(clear|S1|resolve_S1)|light_buckets/.*|exclusive_scan/(cells|light_buckets)/.*"),
    *(Row(CONSTRUCTION, f"S{level}", rf"grid_gather/S{level}|grid_scatter/(resolve_)?S{level}")
      for level in range(2, TOP_LEVEL + 1)),
    Row(CONSTRUCTION, "Merge", r"merge(/.*)?"),
    Row(RENDER, "G-buffer", r"gbuffer(/.*)?|interleave/split_depth"),
    Row(RENDER, "Lighting", r"light_(volumes|gather)(/.*)?"),
    Row(RENDER, "Shadow rays", r"shadow_rays(/.*)?|descent/.*"),
    Row(RENDER, "Shadow filter", r"atrous/.*|interleave/blur_(un)?shadowed_[xy]"),
    Row(RENDER, "Composite", r"compose(/.*)?|interleave/(find_edges|blur_lighting_[xy])"),
    Row(RENDER, "Direct light", r"direct_light(/.*)?"),
    Row(RENDER, "Set-up and display", r"frame_setup(/.*)?|tone_map(/.*)?"),
]

# The stages of point-based global illumination, as in Figure 6 of its paper.
PBGI_ROWS = [
    Row(RENDER, "Primary points", r"point_cut/(?!pack_keys/needed$).*|exclusive_scan/primaries/.*|micro_buffers/choose_leaves|point_reuse/match_.*"),
    Row(RENDER, "Micro-buffers of primary points", r"micro_buffers/(trace_texels|splat_points)"),
    Row(RENDER, "Secondary points", r"point_selection/.*|point_reuse/keep_light|(point_cut/pack_keys|exclusive_scan)/needed.*"),
    Row(RENDER, "Light at points", r"point_light/.*"),
    Row(RENDER, "Propagation", r"point_propagation/.*"),
    Row(RENDER, "Radiance caches", r"radiance_cache"),
    Row(RENDER, "Pixels", r"cache_tiles/.*|exclusive_scan/cache_references/.*|cache_gather"),
    Row(RENDER, "G-buffer, direct light, display", r"gbuffer|direct_light|compose|frame_setup(/.*)?|tone_map(/.*)?"),
]


def assign(names, rows=None):
    """The row of every pass. A pass that no row claims, or several, is an error: totals must be complete."""
    found = {}
    for name in names:
        claims = [row for row in rows or ROWS if re.fullmatch(row.pattern, name)]
        if len(claims) != 1:
            titles = " and ".join(f"'{row.title}'" for row in claims)
            raise BenchError(f"the pass {name} is in {titles or 'no row'} of the tables: tools/benchmarks/steps.py must "
                             "give it exactly one")
        found[name] = claims[0]
    return found


def members(names, phase, rows=None):
    """Title of each row of the phase, in order, with the passes it sums; rows without passes are left out."""
    rows = rows or ROWS
    found = assign(names, rows)
    sums = {row.title: [name for name, its_row in found.items() if its_row == row] for row in rows if row.phase == phase}
    return {title: passes for title, passes in sums.items() if passes}
