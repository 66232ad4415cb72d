"""Names of the passes of five frames of gridlight, as its timings had them."""
import json
from pathlib import Path

FIXTURE = json.loads((Path(__file__).parent / "pass_names.json").read_text())
