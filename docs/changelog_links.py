"""A hook of MkDocs: links of the changelog begin at the root, those of a page in docs/."""

import pathlib

CHANGELOG = pathlib.Path(__file__).parents[1] / "CHANGELOG.md"


def on_page_markdown(markdown, page, **_):
    """The page with the changelog in it, where it asks for that."""
    if page.file.src_uri != "changelog.md":
        return markdown
    text = CHANGELOG.read_text(encoding="utf-8").replace("](docs/", "](")
    return markdown.replace('--8<-- "CHANGELOG.md"', text)
