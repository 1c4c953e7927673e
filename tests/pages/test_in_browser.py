"""Pages in a real browser, Chromium without a window and without network, by Selenium."""

import base64
import json
import shutil
import time

import pytest

from fastdyn import systems
from fastdyn.pages import html as of_page
from fastdyn.pages import plain
from fastdyn.pages.functions import PageFunctions
from support.pages import DERIVED, SOLVE, Case, compare

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
DRIVER = shutil.which("chromedriver")
if not (CHROMIUM and DRIVER):
    pytest.skip("chromium and chromium-driver are not installed", allow_module_level=True)
webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

pytestmark = pytest.mark.browser
WORDS = (
    "headless=new no-sandbox disable-gpu disable-quic no-first-run disable-background-networking "
    "disable-component-update disable-sync disable-dev-shm-usage"
).split()
WIDTHS = {390: 844, 820: 1100, 1200: 900}


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    profile = tmp_path_factory.mktemp("profile")
    for word in (*WORDS, f"user-data-dir={profile}"):
        options.add_argument(f"--{word}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    found = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    found.execute_cdp_cmd("Network.enable", {})
    off = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
    found.execute_cdp_cmd("Network.emulateNetworkConditions", off)
    yield found
    found.quit()


def opened(driver, file, width=1200, address=""):
    """Open a page at a width, and wait for its first curves."""
    size = {"width": width, "height": WIDTHS[width], "deviceScaleFactor": 1}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size | {"mobile": width < 700})
    touch = {"enabled": width < 700}
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", touch)
    driver.get("about:blank")
    driver.get_log("browser")
    driver.get(f"file://{file}{address}")
    until(driver, "return fastdyn.state.updates >= 1")


def until(driver, script, seconds=30.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if driver.execute_script(script):
            return
        time.sleep(0.05)
    raise AssertionError(script)


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory):
    file = tmp_path_factory.mktemp("pages") / "pendulum.html"
    return systems.pendulum(V0=4.0).page(file)


@pytest.mark.parametrize("name", [*systems.SYSTEMS, *DERIVED])
def test_a_page_has_the_numbers_of_fastdyn(name, driver, tmp_path):
    if name not in systems.SYSTEMS:
        pytest.importorskip("sympy", reason="the extra `derive` is not installed")
    case = Case(name)
    functions = PageFunctions(case.first)
    file = tmp_path / "page.html"
    file.write_text(of_page.page(case.first), "utf-8")
    opened(driver, file)
    calls, runs = case.runs(functions)
    given = f"return answers({json.dumps(calls)}, {json.dumps(case.events())})"
    compare(calls, runs, driver.execute_script(f"{SOLVE}\n{given}"))
    drawn = driver.execute_script(
        "const count = (id) => { const one = document.querySelector(`${id} canvas`);"
        "  const data = one.getContext('2d').getImageData(0, 0, one.width, one.height).data;"
        "  return data.filter((x, i) => i % 4 === 3 && x > 0).length; };"
        "return ['#stage', '#component', '#phase', '#kept', '#value'].filter("
        "  (id) => document.querySelector(`${id} canvas`)).map(count)"
    )
    assert len(drawn) >= 3 and min(drawn) > 100
    assert driver.get_log("browser") == []
    resources = "return performance.getEntriesByType('resource').length"
    assert driver.execute_script(resources) == 0


@pytest.mark.parametrize("width", WIDTHS)
def test_a_page_fits_its_window(width, driver, pendulum):
    opened(driver, pendulum, width)
    wide = "return [document.documentElement.scrollWidth, innerWidth]"
    scrolled, inner = driver.execute_script(wide)
    assert scrolled <= inner
    first = driver.execute_script(  # what a newcomer sees without scrolling
        "return ['pause', 'stage', 'ways', 'kept'].map("
        "  (id) => document.getElementById(id).getBoundingClientRect().top < innerHeight)"
    )
    assert first == [True] * 4
    assert driver.get_log("browser") == []


def test_a_slider_moves_curves_and_numbers(driver, pendulum):
    opened(driver, pendulum)
    before = driver.execute_script("return document.getElementById('numbers').innerText")
    driver.execute_script(
        "const one = document.querySelectorAll('#side input[type=range]')[1]; one.value = 2;"
        "one.dispatchEvent(new Event('input'))"
    )
    until(driver, "return fastdyn.state.p[1] === 2 && fastdyn.state.updates >= 2")
    after = driver.execute_script("return document.getElementById('numbers').innerText")
    assert after != before and "2.21472 rad/s" in after  # sqrt(9.81 / 2)
    assert driver.execute_script("return location.hash") == "#l=2"


def test_a_link_holds_the_state(driver, pendulum):
    address = "#l=0.5&V0=-2&method.1=RK4&step.1=0.02&t.end=7&y0=1.5 0"
    opened(driver, pendulum, address=address)
    state = driver.execute_script(
        "const s = fastdyn.state; return [Array.from(s.p), s.ways[1], s.tEnd, s.y0]"
    )
    assert state[0][1:3] == [0.5, -2.0] and state[2:] == [7.0, [1.5, 0.0]]
    assert (state[1]["method"], state[1]["step"]) == ("RK4", 0.02)
    said = "l=<script>&V0=NaN&method.0=alert&y0=1 2 3&t.end=-1"
    opened(driver, pendulum, address=f"#{said}")
    assert driver.execute_script("return [Array.from(fastdyn.state.p), fastdyn.state.y0]") == [
        [9.81, 1.0, 4.0, 1.0, 0.0], None,
    ]  # fmt: skip
    assert driver.get_log("browser") == []


def test_words_that_are_no_numbers_are_answered(driver, pendulum):
    opened(driver, pendulum)
    for text, said in (
        ("1,5", "with a point it is 1.5"),
        ("-1", "greater than zero"),
        ("x", "no number"),
    ):
        driver.execute_script(
            "const one = document.querySelectorAll('#side input[type=text]')[1];"
            "one.value = arguments[0]; one.dispatchEvent(new Event('change'))", text,
        )  # fmt: skip
        assert said in driver.execute_script("return document.getElementById('said').textContent")
        assert driver.execute_script("return fastdyn.state.p[1]") == 1.0


def test_a_finger_drags_the_mass(driver, pendulum):
    opened(driver, pendulum, 390)
    box = driver.execute_script(
        "document.getElementById('pause').click();"
        "const [r, s] = ['#stage .handle', '#stage'].map("
        "  (name) => document.querySelector(name).getBoundingClientRect());"
        "const middle = (one) => [one.x + one.width / 2, one.y + one.height / 2];"
        "return [...middle(r), ...middle(s), scrollY]"
    )
    x, y, cx, cy, scrolled = box

    def touch(kind, *points):
        given = [{"x": px, "y": py} for px, py in points]
        driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})

    touch("touchStart", (x, y))
    target = (cx + 60, cy)  # beside the pivot, a quarter turn away
    for k in range(1, 11):
        touch("touchMove", (x + (target[0] - x) * k / 10, y + (target[1] - y) * k / 10))
        time.sleep(0.03)
    touch("touchEnd")
    until(driver, "return fastdyn.state.y0 !== null")
    until(driver, "return !fastdyn.state.dirty")
    theta, omega = driver.execute_script("return fastdyn.state.y0")
    assert 1.3 < theta < 1.8 and omega == 4.0
    assert driver.execute_script("return scrollY") == scrolled
    assert driver.execute_script("return document.querySelector('.hint') === null")
    driver.execute_script("document.getElementById('reset').click()")
    until(driver, "return fastdyn.state.y0 === null")


def test_the_pause_stops_the_motion(driver, pendulum):
    opened(driver, pendulum)
    driver.execute_script("document.getElementById('pause').click()")
    before = driver.execute_script("return fastdyn.state.time")
    time.sleep(0.3)
    assert driver.execute_script("return fastdyn.state.time") == before
    text = driver.execute_script("return document.getElementById('pause').textContent")
    assert "Play" in text


def test_files_are_made(driver, pendulum):
    opened(driver, pendulum)
    table = driver.execute_script("return fastdyn.table()")
    head, first, *rest = table.splitlines()
    assert head == (
        "t (s),theta (rad),omega (rad/s),energy (J),tension (N)"
    ) and first.startswith("0,0,4,") and len(rest) > 500  # fmt: skip
    png = driver.execute_script("return picture().toDataURL()").partition(",")[2]
    assert base64.b64decode(png)[:8] == b"\x89PNG\r\n\x1a\n"


def test_a_contact_that_pulls_is_told(driver, tmp_path):
    pytest.importorskip("sympy", reason="the extra `derive` is not installed")
    from fastdyn.derive import Model, i, j, t

    board = Model("lift")
    x, y = board.coordinates("x y")
    ball = board.particle(2.0, x * i + y * j, "ball")
    ball.force((10 - 20 * t) * j)
    ball.slides(j, board.reactions("N"), through=0 * i)
    board.start(vx=1.0)
    with pytest.warns(UserWarning, match="normal force N of the lift is negative"):
        file = board.newton().system().page(tmp_path / "lift.html")
    opened(driver, file)
    said = driver.execute_script("return document.getElementById('said').textContent")
    assert said.startswith("The normal force N is negative from about t = 0 s")
    assert said.endswith("ball would leave a surface there.")


def test_a_terminal_event_of_a_plain_function_ends_the_run(driver, tmp_path):
    def falling(t, y, g):
        return [y[1], -g]

    def low(t, y, g):
        return y[0] + 1.0

    def twice(t, y, g):
        return y[0]

    low.terminal = True
    twice.terminal = 2
    system = plain.system_of(falling, "fall", [0.0, 3.0], (9.81,), {"low": low, "twice": twice})
    file = tmp_path / "page.html"
    file.write_text(of_page.page(system), "utf-8")
    opened(driver, file)
    (end,) = driver.execute_script(
        "return fastdyn.state.runs.map((run) => run.t[run.t.length - 1])"
    )
    assert end == pytest.approx((3.0 + (9.0 + 2 * 9.81) ** 0.5) / 9.81, rel=1e-9)
    said = driver.execute_script("return document.body.textContent")
    assert "its occurrence 2 does" in said


def test_answers_of_the_first_values_say_so(driver, tmp_path):
    """The exact period of a pendulum is an elliptic integral, which a page has as a number."""
    file = systems.pendulum(V0=1.0).page(tmp_path / "pendulum.html")
    opened(driver, file)
    said = "return document.body.innerText.includes('for the first values only')"
    assert not driver.execute_script(said)
    driver.execute_script("fastdyn.state.p[0] *= 1.1; fastdyn.state.dirty = true")
    until(driver, said)
