"""Checks the documents: length of sentences, cells and paragraphs, headings, links, JSON, and words to avoid.

Words to avoid are also looked for in the SOURCES; tests/architecture/wording.rs checks the crates.

A finding is `FILE:LINE: RULE: TEXT`. EXCEPTIONS are allowed, each with its reason.
"""

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from subprocess import run

ROOT = Path(__file__).parents[2]
DOCUMENTS = ("*.md", "docs/**/*.md", "clients/*/README.md", "crates/*/README.md", "tests/*/README.md", "viewer/README.md")
SOURCES = "benches clients deploy examples proto tests/conformance tests/golden tests/python Makefile Dockerfile build.rs"
LIMITS = {"sentence": 35, "cell": 20, "paragraph": 90}  # words
QUESTION = r"(how(?!-)|what|why|when|where|which|who|whom|whose|whether)\b|.*\?$"
AVOIDED = [line.partition(":")[0].split(", ") for line in (ROOT / "tests/words.txt").read_text().splitlines() if line[0] != "#"]
AVOIDED = r"\b(" + "|".join(it if it[0].isupper() else f"(?i:{it})" for it in sum(AVOIDED, [])) + r")\b"
EXCEPTIONS = {("tests/python/prose.py", "who"): "the words of questions"}  # file and a part of the text: reason


def words(text: str) -> int:
    """Code counts as one word, a link as its text."""
    text = re.sub(r"`[^`]*`", "code", re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", text))
    return len(re.findall(r"[^\W\d_][\w'’-]*|\d[\d.,e^-]*", text))


def anchors(path: Path) -> set[str]:
    """The anchors that GitHub generates for headings."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", path.read_text(), flags=re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


def parts(text: str) -> Iterator[tuple[int, str, str]]:
    """Line, kind (fence, heading, row, text) and content; each item of a list is a text."""
    fence, start, gathered = "", 0, []
    for number, line in enumerate([*text.splitlines(), ""], 1):
        mark = line.strip() if line.lstrip().startswith("```") else ""
        ends = mark or not fence and (not line.strip() or re.match(r"\s*([-*]|\d+\.) |[#|<]", line))
        if gathered and ends:
            yield start, fence or "text", ("\n" if fence else " ").join(gathered)
            gathered = []
        if mark:
            fence = "" if fence else mark
        elif not fence and line.startswith(("#", "|")):
            yield number, "heading" if line[0] == "#" else "row", line.lstrip("# ")
        elif line.strip() and not line.startswith("<"):
            start = start if gathered else number
            gathered.append(line.strip())


def is_json(text: str) -> bool:
    """True if it runs as it stands."""
    try:
        return json.loads(text) is not None and not re.search(r"…|\.\.\.", text)
    except ValueError:
        return False


def findings(path: Path) -> Iterator[tuple[int, str, str]]:
    """Line, rule and text of each finding."""
    for line, kind, text in parts(path.read_text()):
        if kind == "```json" and not is_json(text):
            yield line, "json", text
        if kind not in ("heading", "row", "text"):
            continue
        plain = re.sub(r"`[^`]*`", "`code`", text)
        if kind == "heading" and re.match(QUESTION, plain, re.I):
            yield line, "heading", text
        cells = re.split(r"(?<!\\)\|", plain) if kind == "row" else []
        sentences = re.split(r"(?<=[.!?])[)\"”*]* +(?=[^a-z\d])", plain) if kind == "text" else []
        measured = {"cell": cells, "sentence": sentences, "paragraph": [plain] if kind == "text" else []}
        for rule, limit in LIMITS.items():
            yield from ((line, rule, f"{words(it)} words: {it.strip()}") for it in measured[rule] if words(it) > limit)
        yield from ((line, "word", found[0]) for found in re.finditer(AVOIDED, plain))
        for link in re.findall(r"\]\(([^)\s]+)\)", plain):
            file, _, heading = link.partition("#")
            target = path.parent / file if file else path
            if "://" not in link and not (target.exists() and (not heading or heading in anchors(target))):
                yield line, "link", link


def sources() -> Iterator[tuple[str, int, str, str]]:
    """Name, line, rule and text of each word to avoid in the sources."""
    names = run(["git", "ls-files", "--", *SOURCES.split()], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in names.splitlines():
        if Path(name).suffix not in (".md", ".png", ".json"):
            lines = enumerate((ROOT / name).read_text().splitlines(), 1)
            yield from ((name, k, "word", found[0]) for k, line in lines for found in re.finditer(AVOIDED, line))


found = [(path.relative_to(ROOT).as_posix(), *it) for glob in DOCUMENTS for path in ROOT.glob(glob) for it in findings(path)]
found = sorted(it for it in [*found, *sources()] if not any(it[0] == name and part in it[3] for name, part in EXCEPTIONS))
for name, line, rule, text in found:
    print(f"{name}:{line}: {rule}: {text[:160]}")
sys.exit(f"{len(found)} findings: {dict(Counter(it[2] for it in found))}" if found else 0)
