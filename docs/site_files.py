"""Hooks of the site: pages and pictures of docs/ beside docs/pages, and links that lead out of the site."""

import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

HERE = Path(__file__).parent
OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./[^)]*\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    for path in (*HERE.glob("*.md"), *HERE.glob("*.png"), *HERE.glob("speed/*")):
        files.append(File.generated(config, path.relative_to(HERE).as_posix(), abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """Links to the rest of the repository keep their text only."""
    return OUTSIDE.sub(r"\1", markdown)
