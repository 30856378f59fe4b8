"""The site: it builds without a warning, loads nothing from elsewhere, and its equations are typeset."""

import html.parser
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "pages"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the built site, made from a copy: the generator writes beside its configuration only."""
    pytest.importorskip("zensical", reason="needs the extra docs")
    folder = tmp_path_factory.mktemp("site")
    shutil.copy(ROOT / "mkdocs.yml", folder)
    shutil.copytree(PAGES, folder / "docs" / "pages")
    build = [sys.executable, "-m", "zensical", "build", "--strict"]
    done = subprocess.run(build, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "No issues found" in done.stderr, done.stdout + done.stderr
    return folder / "build" / "site"


class Tags(html.parser.HTMLParser):
    """Tags of a page, each with its attributes."""

    def __init__(self, text):
        super().__init__()
        self.tags = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))


def test_every_page_is_in_the_site_and_in_its_contents(site):
    sources = {path.relative_to(PAGES).with_suffix(".html") for path in PAGES.rglob("*.md")}
    assert len(sources) > 15 and all((site / page).exists() for page in sources)
    contents = {tag[1].get("href", "").removeprefix("./") for tag in Tags((site / "index.html").read_text()).tags}
    assert {page.as_posix() for page in sources} - contents == set()


def test_no_page_loads_anything_from_elsewhere_and_all_that_it_loads_is_there(site):
    loaded = 0
    for page in site.rglob("*.html"):
        for tag, attributes in Tags(page.read_text(encoding="utf-8")).tags:
            address = attributes.get("href" if tag in ("link", "image", "use") else "src")
            if tag in ("script", "link", "img", "iframe", "source", "image", "use") and address:
                assert not re.match(r"(\w+:)?//", address), (page.name, address)
                home = site if address.startswith("/") else page.parent
                target = (home / address.split("#")[0].lstrip("/")).resolve()
                assert tag != "link" or attributes["rel"] != "stylesheet" or target.exists(), (page.name, address)
                assert tag in ("link", "use") or target.exists(), (page.name, address)
                loaded += 1
    assert loaded > 100
    for sheet in (*site.rglob("*.css"), *site.rglob("*.js")):
        assert not re.search(r"(@import|url\()\s*[\"']?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet.name


@pytest.mark.long
def test_every_equation_is_typeset(site, browser):
    """What stands between $ and $, or in a block `math`; TeX that KaTeX does not know would be an error."""
    tab, equations = browser.new_page(), {}
    for page in sorted(PAGES.rglob("*.md")):
        text = re.sub(r"^( *)```(?!math)\w+\n.*?^\1```$", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
        text = re.sub(r"(?<!`)`[^`\n]+`", "", text)
        if "$" in text or "```math" in text:
            tab.goto((site / page.relative_to(PAGES).with_suffix(".html")).as_uri())
            found = tab.locator(".arithmatex").count()
            equations[page.stem] = found
            assert found == text.count("```math") + text.count("$") // 2, page.stem
            assert tab.locator(".arithmatex .katex .katex-html").count() == found, page.stem
            fonts = tab.evaluate("[...document.fonts].filter(face => face.status == 'loaded').map(face => face.family)")
            assert "KaTeX_Math" in fonts and tab.locator(".katex-error").count() == 0, page.stem
    tab.close()
    assert equations["theory"] > 150 and len(equations) > 3


@pytest.mark.long
def test_pages_open_from_a_folder_ask_for_nothing_else_and_their_search_finds(site, browser):
    asked, complaints = [], []
    tab = browser.new_page()
    tab.on("request", lambda request: asked.append(request.url))
    tab.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    for page in ("theory", "gallery", "speed/index", "index"):
        tab.goto((site / f"{page}.html").as_uri())
    tab.keyboard.press("Control+k")
    tab.keyboard.type("odometry")
    tab.get_by_text(re.compile(r"^[1-9]\d* results$")).wait_for()
    tab.close()
    assert all(url.startswith(("file:", "data:", "blob:", "about:")) for url in asked) and complaints == []
