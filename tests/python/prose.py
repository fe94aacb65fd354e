"""Reads the documents and reports, by file and line, what is hard to read and which links lead nowhere.

STILL_FAILING names the documents that do not keep a rule yet. It only shrinks: a document that keeps the rule must leave
it. EXCEPTIONS are single findings, by document and beginning of the text, each with its reason. `--counts` prints the
number of findings of each document and rule, `--all` also the findings of STILL_FAILING.
"""

import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCUMENTS = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "docs/*.md", "clients/*/README.md")
LIMITS = {"sentence": 35, "cell": 20, "paragraph": 90}  # words
RULES = (*LIMITS, "heading", "link", "json", "word")
QUESTION = r"(how(?!-)|what|why|when|where|which|who|whom|whose|whether)\b|.*\?$"
PRIVATE = (
    r"\b(told|tells|foretells?|foresees?|foreseen|so many|as many as it takes|whom|whoever|nobody|patience|patiently"
    r"|suspects?|blamed?|crowds?|comes? again|goes on|go on|(?:breaks?|broke) off|mistakes?|made-up|stands? still|exhibits?"
    r"|without a word|what is wrong)\b"
)
STILL_FAILING: dict[str, str] = {
    "paragraph": "clients/csharp/README.md",
}
EXCEPTIONS: dict[tuple[str, str], str] = {}


def words(text: str) -> int:
    """Code counts as one word, a link as its text."""
    text = re.sub(r"`[^`]*`", "code", re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", text))
    return len(re.findall(r"[^\W\d_][\w'’-]*|\d[\d.,e^-]*", text))


def anchors(path: Path) -> set[str]:
    """What GitHub makes of the headings."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", path.read_text(), flags=re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


def parts(text: str) -> Iterator[tuple[int, str, str]]:
    """Line, kind (fence, heading, row, text) and content; an item of a list is a text of its own."""
    fence, start, gathered = "", 0, []
    for number, line in enumerate([*text.splitlines(), ""], 1):
        mark = line.strip() if line.lstrip().startswith("```") else ""
        if gathered and (mark or not line.strip() or re.match(r"\s*([-*]|\d+\.) |[#|<]", line)):
            yield start, "text", " ".join(gathered)
            gathered = []
        if fence or mark:
            yield number, fence, line
            fence = fence if not mark else "" if fence else mark
        elif line.startswith(("#", "|")):
            yield number, "heading" if line[0] == "#" else "row", line.lstrip("# ")
        elif line.strip() and not line.startswith("<"):
            start = start if gathered else number
            gathered.append(line.strip())


def findings(path: Path) -> Iterator[tuple[int, str, str]]:
    for line, kind, text in parts(path.read_text()):
        if kind == "```json" and re.search(r"…|\.\.\.", text):
            yield line, "json", text.strip()
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
        yield from ((line, "word", found[0]) for found in re.finditer(PRIVATE, plain, re.I))
        for link in re.findall(r"\]\(([^)\s]+)\)", plain):
            file, _, heading = link.partition("#")
            target = path.parent / file if file else path
            if "://" not in link and not (target.exists() and (not heading or heading in anchors(target))):
                yield line, "link", link


count, wrong = Counter(), []
names = sorted(path.relative_to(ROOT).as_posix() for pattern in DOCUMENTS for path in ROOT.glob(pattern))
for name in names:
    for line, rule, text in findings(ROOT / name):
        excepted = any(name == where and beginning in text for where, beginning in EXCEPTIONS)
        count[name, rule] += not excepted
        if not excepted and ("--all" in sys.argv or name not in STILL_FAILING.get(rule, "").split()):
            wrong.append(f"{name}:{line}: {rule}: {text[:160]}")
for rule, failing in STILL_FAILING.items():
    wrong += [f"{name} keeps the rule {rule}: take it out of STILL_FAILING" for name in failing.split() if not count[name, rule]]
if "--counts" in sys.argv:
    for row in ("", *names, "all"):
        cells = [count[row, rule] if row != "all" else sum(count[name, rule] for name in names) for rule in RULES]
        print(f"{row:30}", *(f"{cell:>9}" for cell in (cells if row else RULES)))
print("\n".join(wrong), end="\n" if wrong else "", file=sys.stderr)
sys.exit(bool(wrong))
