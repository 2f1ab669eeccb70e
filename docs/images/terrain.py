"""Draw docs/images/terrain.png, the picture of the README: python docs/images/terrain.py."""

import io
from pathlib import Path

from PIL import Image

from fieldreport.experiments import get

WIDTH = 1600
COLORS = 256

experiment = get("terrain")
page = experiment.plots["terrain"](experiment.run())
buffer = io.BytesIO()
page.savefig(buffer, format="png", dpi=WIDTH / page.get_figwidth())
picture = Image.open(buffer).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
picture.save(Path(__file__).with_suffix(".png"), optimize=True)
