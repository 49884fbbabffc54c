"""Checks that every relative link of the documents leads to something that is installed with them, and that every path
of the sources in backquotes exists.

usage: doc_links.py ROOT DOCUMENT…     a document is a file or a folder below ROOT

A reader of the package has the documents and nothing else of the sources."""
import pathlib
import re
import sys

LINK = re.compile(r"\]\(\s*<?([^)>\s]+)")  # of Markdown, pictures, too
HEADING = re.compile(r"^#+ +(.*?) *$", re.M)


def without_code(text):
    """Text between fences or backquotes has no links."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))


def anchors(text):
    """As the usual renderers name headings."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in HEADING.findall(text)}


def dead_links(file, documents):
    """(link, why) of links without a target."""
    for link in LINK.findall(without_code(file.read_text())):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (file.parent / path).resolve() if path else file
        if not target.exists():
            yield link, "there is no such file"
        elif not any(target == document or document in target.parents for document in documents):
            yield link, "it is not installed with the documents"
        elif anchor and target.suffix == ".md" and anchor not in anchors(target.read_text()):
            yield link, "there is no such heading"


PATH = re.compile(r"`((?:idl|world|planner|services|examples|deploy|tests|docs|cmake)/[a-z0-9_./-]+)`")
NODE = re.compile(r"planner/[a-z0-9]+")  # not a path


def dead_paths(file, root):
    """(path, why) of those that name nothing; a name without its ending may stand for a header or a source."""
    for path in sorted(set(PATH.findall(re.sub(r"^```.*?^```", "", file.read_text(), flags=re.M | re.S)))):
        if not NODE.fullmatch(path) and not any((root / f"{path}{ending}").exists() for ending in ("", ".hpp", ".cpp", ".py")):
            yield path, "there is no such file or folder in the sources"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    documents = [root / name for name in sys.argv[2:]]
    texts = [file for document in documents
             for file in (sorted(document.rglob("*.md")) if document.is_dir() else [document]) if file.suffix == ".md"]
    dead = [f"{file.relative_to(root)}: {link}: {why}" for file in texts for link, why in dead_links(file, documents)]
    dead += [f"{file.relative_to(root)}: {path}: {why}" for file in texts for path, why in dead_paths(file, root)]
    print("\n".join(dead) or f"the links of {len(texts)} documents lead somewhere")
    return 1 if dead or not texts else 0


if __name__ == "__main__":
    sys.exit(main())
