"""Pages in a browser: what a move of a slider costs, in headless Chromium without a GPU."""

import contextlib
import pathlib
import shutil
import statistics
import tempfile

SYSTEMS = (
    "projectile", "nanoparticle", "tower", "suspension", "rod", "pendulum", "cable", "drag",
    "satellite", "building", "pendulum_xy", "vehicle", "double_pendulum", "rolling_disc",
)  # fmt: skip
TOLERANCES = (1e-6, 1e-8)
MOVES, COLD = 60, 20  # of a slider; the first ones, which the browser compiles, are left out
WORDS = "headless=new no-sandbox disable-gpu no-first-run disable-background-networking"
MOVE = """
const done = arguments[1], found = [], start = DATA.sliders.findIndex((one) => !one.initial);
state.ways[0].rtol = arguments[0];
const slider = document.querySelectorAll('#side input[type=range]')[start];
function move() {
  if (found.length === %d) { done(found); return; }
  slider.value = DATA.sliders[start].value * (1 + 0.003 * found.length);
  slider.dispatchEvent(new Event('input'));
  const before = state.updates;
  function wait() {
    if (state.updates === before) { requestAnimationFrame(wait); return; }
    found.push([state.milliseconds, state.runs.reduce((sum, run) => sum + run.milliseconds, 0)]);
    move();
  }
  wait();
}
move();
"""


def rows(quick):
    """A row a system and tolerance: milliseconds from the move to the drawn curves.

    `ms` is the median of a move (two solves, samples, four pictures), `least_ms` the least, and
    `solves_ms` the median of the two solves alone.
    """
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    try:
        from selenium import webdriver
    except ImportError:
        return
    if not (chromium and driver):
        return
    from fastdyn.explore.sources import named
    from fastdyn.pages import write

    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for word in WORDS.split():
        options.add_argument(f"--{word}")
    with tempfile.TemporaryDirectory() as folder, contextlib.closing(_Browser(options)) as browser:
        for name in SYSTEMS[: 2 if quick else None]:
            source = named(name)
            file = write(source.make(**source.values), pathlib.Path(folder, f"{name}.html"))
            for rtol in TOLERANCES[: 1 if quick else None]:
                moves = browser.moves(file, rtol)[COLD:]
                whole = [each for each, _ in moves]
                yield {
                    "system": name, "rtol": rtol, "ms": statistics.median(whole),
                    "least_ms": min(whole), "solves_ms": statistics.median([s for _, s in moves]),
                    "kB": file.stat().st_size / 1000,
                }  # fmt: skip


class _Browser:
    def __init__(self, options):
        from selenium import webdriver

        service = webdriver.ChromeService(shutil.which("chromedriver"))
        self._driver = webdriver.Chrome(options=options, service=service)

    def moves(self, file, rtol):
        self._driver.get(f"file://{file}")
        return self._driver.execute_async_script(MOVE % MOVES, rtol)

    def close(self):
        self._driver.quit()
