"""The page in a real browser: Chromium without a window, by Selenium."""

import importlib.util
import json
import shutil
import time
import urllib.request

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
DRIVER = shutil.which("chromedriver")
if not (CHROMIUM and DRIVER):
    pytest.skip("chromium and chromium-driver are not installed", allow_module_level=True)
if not importlib.util.find_spec("panel"):  # its import takes 1.2 s in each process of tests
    pytest.skip("the extra `explore` is not installed", allow_module_level=True)
webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

pytestmark = pytest.mark.browser
FIND = """
const found = [], selector = SELECTOR;
function walk(root) {
  for (const one of root.querySelectorAll('*')) {
    if (one.matches(selector)) found.push(one);
    if (one.shadowRoot) walk(one.shadowRoot);
  }
}
walk(document);
return found;
"""


class Browser:
    """The actions of a test in a tab."""

    def __init__(self, driver):
        self.driver = driver

    def find(self, selector):
        """Elements in the page and its shadow roots."""
        return self.driver.execute_script(FIND.replace("SELECTOR", json.dumps(selector)))

    def curve(self, n=0):
        """A curve as the browser has it."""
        return self.driver.execute_script(
            f"const one = Bokeh.documents[0].get_model_by_name('curve {n}');"
            "return one ? Array.from(one.data.a) : [];"
        )

    def settled(self):
        """The curve, after the moves that are on their way."""
        found = []
        while found != (found := self.curve()):
            time.sleep(1.0)
        return found

    def text(self):
        """The numbers, and what is wrong."""
        return " ".join(one.text for one in self.find("table.numbers, .alert"))

    def until(self, holds, seconds=30.0):
        """Wait until something holds; whether it does."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                if holds():
                    return True
            except Exception:
                pass  # the page is not there yet
            time.sleep(0.1)
        return False


@pytest.fixture(scope="module")
def address():
    from fastdyn.explore.serve import serve
    from fastdyn.explore.sources import named

    address, server = serve(named("pendulum"), show=False, threaded=True)
    yield address
    server.stop()
    server.join(60.0)  # `stop` asks the thread to end; pages that are open are still answered
    with pytest.raises(OSError):  # nobody answers any more
        urllib.request.urlopen(address, timeout=2.0)


@pytest.fixture(scope="module")
def browser(address):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for word in ("headless=new", "no-sandbox", "disable-dev-shm-usage", "window-size=1300,950"):
        options.add_argument(f"--{word}")
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.get(address)
    found = Browser(driver)
    assert found.until(lambda: len(found.curve()) > 100)
    yield found
    driver.quit()


def test_the_page_is_of_this_machine_alone(browser, address):
    script = "return performance.getEntriesByType('resource').map(one => one.name)"
    assert all(one.startswith(address) for one in browser.driver.execute_script(script))
    assert "RK45, rtol 1e-06" in browser.text()


def test_a_slider_that_is_moved_changes_curve_and_numbers(browser):
    from selenium.webdriver.common.keys import Keys

    before, numbers = browser.curve(), browser.text()
    handle = browser.find(".noUi-handle")[0]  # of g
    handle.send_keys(Keys.ARROW_RIGHT * 20)
    assert browser.until(lambda: browser.curve() != before)
    assert browser.until(lambda: browser.text() != numbers)


def test_wrong_input_is_answered_by_a_sentence(browser):
    from selenium.webdriver.common.keys import Keys

    before = browser.settled()
    number = browser.find("input[type=text]")[1]  # of l
    number.send_keys(Keys.END, Keys.BACKSPACE * 5, "-1", Keys.ENTER)
    assert browser.until(lambda: "greater than zero" in browser.text())
    assert browser.curve() == before
    for text, sentence in (
        ("1,5", "'1,5' is no number; with a point it is 1.5."),
        ("abc", "'abc' is"),
    ):
        number.send_keys(Keys.END, Keys.BACKSPACE * 5, text, Keys.ENTER)
        assert browser.until(lambda said=sentence: said in browser.text())
        assert browser.curve() == before
    number.send_keys(Keys.END, Keys.BACKSPACE * 5, "0.5", Keys.ENTER)
    assert browser.until(lambda: "is no number" not in browser.text())
    assert browser.until(lambda: browser.curve() != before)


def test_the_page_fits_windows_of_every_width(browser):
    size, wide = browser.driver.get_window_size(), []
    assert browser.driver.execute_script("return !!document.querySelector('meta[name=viewport]')")
    for width in (500, 1300, 1900):
        browser.driver.set_window_size(width, 950)
        over = "return document.documentElement.scrollWidth > document.documentElement.clientWidth"
        assert browser.until(lambda over=over: not browser.driver.execute_script(over))
        browser.until(lambda: len(browser.find(".bk-Figure")) == 4)
        wide.append(max(one.rect["x"] + one.rect["width"] for one in browser.find(".bk-Figure")))
    assert wide[0] <= 500 and wide[1] > 1200 and wide[2] > 1800  # no side is unused
    browser.driver.set_window_size(size["width"], size["height"])


def test_two_tabs_do_not_disturb_each_other(browser, address):
    from selenium.webdriver.common.keys import Keys

    changed, first = browser.curve(), browser.driver.current_window_handle
    browser.driver.switch_to.new_window("tab")
    browser.driver.get(address)
    assert browser.until(lambda: len(browser.curve()) > 100)
    fresh = browser.curve()
    assert fresh != changed
    browser.find(".noUi-handle")[0].send_keys(Keys.ARROW_RIGHT * 5)
    assert browser.until(lambda: browser.curve() != fresh)
    browser.driver.close()
    browser.driver.switch_to.window(first)
    assert browser.curve() == changed


def test_what_is_chosen_is_announced_at_once(browser):
    from selenium.webdriver.support.ui import Select

    Select(browser.find("select")[0]).select_by_value("heavy_top")
    assert browser.until(lambda: "heavy_top is being made" in browser.text(), 3.0)
    assert browser.until(lambda: len(browser.find(".slider-h, .noUi-handle")) > 3, 120.0)
