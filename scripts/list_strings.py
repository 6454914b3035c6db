#!/usr/bin/env python3
"""Lists the text a user can read, with file and line, and counts it by the rules of plain words.

    scripts/list_strings.py                 counts by crate and by rule
    scripts/list_strings.py --list          every string of four words and more: FILE:LINE KIND TEXT
    scripts/list_strings.py --breaches      only the strings that break a rule, with the rule
    scripts/list_strings.py --list PATH...  the same of some files or folders

Text is: string literals outside tests, the help texts of the command line (doc comments of clap's types), strings and docstrings of the
Python package, cells of the notebooks in docs/notebooks, the prose of CHANGELOG.md and of packaging, and with PATH that of other
Markdown files.
"""
import ast
import json
import pathlib
import re
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LEAST_WORDS = 4
# Rule, pattern. Case is ignored. scripts/check_words.sh holds the same patterns.
FORBIDDEN = [
    ("is no", r"\b(is|are|was|were) no\b(?! (more|less|longer|later|earlier|larger|smaller|better|worse)\b)"),
    ("none is", r"\bnone (is|are|was|were|of (them|these|it) (is|are))\b"),
    ("nobody", r"\bnobody\b"),
    ("nothing but", r"\bnothing (but|else)\b"),
    ("tell", r"\b(tells?|told)\b"),
    ("by itself", r"\bby (itself|themselves)\b"),
    ("as well as may be", r"\bas \w+ as may be\b"),
    ("personified", r"\b(data|channels?|samples?|windows?|sensors?|recordings?|filters?|files?) (say|know|knows|feel|feels|believe|believes|ask|asks|want|wants|contradict each other)\b"),
    ("hang together", r"\bhangs? together\b"),
    ("stands", r"\b(stands?|stood)\b(?! (for|alone|still|on)\b)"),
    ("is said", r"\b(is|are|was|were|be|being) (said|asked|wanted|believed|meant)\b|\bmay be believed\b"),
    ("in the place of", r"\bin (the|its|their) place( of)?\b"),
    ("what-clause", r"(^|[.:;] )What \w+ (?!\w*\?)[^?]*$|(^|[.:;] )What (is|was|are|were) not\b"),
    ("mend", r"\b(mend|mends|mended|mending)\b"),
    ("deviations", r"(?<!`)\bdeviations?\b(?<!std deviation)(?<!standard deviation)(?<!standard deviations)"),
    ("flown again", r"\bflown again\b"),
    ("lend and borrow", r"\b(borrows?|lends?|borrowed)\b"),
    ("to and fro", r"\bto and fro\b|\bturned over\b"),
    ("cure", r"\bcures?\b"),
    ("anew", r"\banew\b|\bcalled so\b"),
    ("hold the truth", r"\b(holds?|held) the truth\b|\bspeaks? for\b"),
]
LONGEST = {"finding": 15, "finding in parts": 15, "fix": 12, "help": 12}
UNITS = {"s", "m", "deg", "rad", "Pa", "kg", "m2", "m/s", "m/s2", "deg/s", "rad/s", "Hz", "ms", "kt", "ft"}
MARKS = re.compile(r"\{[^{}]*\}")


def literals(text):
    """String literals of Rust source: (line, position, text), with those of test modules left out."""
    position, line, size = 0, 1, len(text)
    token = re.compile(
        r'//[^\n]*|/\*.*?\*/|b?r(#*)".*?"\1|b?"(?:[^"\\]|\\.)*"|\'(?:[^\'\\\n]|\\.[^\']*)\'|#\[cfg\(test\)\]', re.S
    )
    while position < size:
        found = token.search(text, position)
        if not found:
            return
        line += text.count("\n", position, found.start())
        piece = found.group(0)
        if piece.startswith("#[cfg(test)]"):
            rest = text[found.end() : found.end() + 40]
            if re.match(r"\s*mod \w+ \{", rest):
                return
        elif piece.startswith(('"', 'r"', "r#", 'b"', 'br')):
            inner = piece[piece.index('"') + 1 : piece.rindex('"')]
            if not piece.lstrip("b").startswith("r"):
                inner = re.sub(r"\\\n\s*", "", inner).replace("\\n", "\n").replace('\\"', '"')
            yield line, found.start(), inner
        line += piece.count("\n")
        position = found.end()


def help_lines(text):
    """Doc comments of the types clap makes its help of, and of the table of commands: (line, text)."""
    lines = text.split("\n")
    depth_of_type = None
    is_clap, depth, block, first = False, 0, [], 0
    for number, raw in enumerate(lines, 1):
        line = raw.strip()
        if line.startswith("#[derive(") and re.search(r"\b(Parser|Args|Subcommand|ValueEnum)\b", line):
            is_clap = True
        is_clap |= line == "commands! {"
        if line.startswith("///"):
            if not block:
                first = number
            block.append(line[3:].strip())
            continue
        if line.startswith("#["):
            continue
        inside = depth_of_type is not None and depth > depth_of_type
        if block and (inside or is_clap):
            yield first, " ".join(block)
        block = []
        if is_clap and re.match(r"((pub(\([^)]*\))? )?(struct|enum)|commands!) ", line):
            depth_of_type, is_clap = depth, False
        code = re.sub(r'"(?:[^"\\]|\\.)*"', "", line.split("//")[0])
        depth += code.count("{") - code.count("}")
        if depth_of_type is not None and depth <= depth_of_type and "{" not in code:
            depth_of_type = None


def kind(path, before):
    """Whether a literal is a finding of the verdict, its fix, a finding of another room (with its fix behind a colon), or other text."""
    name = str(path)
    if "/verdict/" in name:
        return "fix" if re.search(r"(cure|fix|fix_text|Fix::new)\W[^;]*$", before, re.I) else "finding"
    return "finding in parts" if re.search(r"engine/src/(stage|study|session)/|core/src/compatibility/", name) else "text"


def words(text):
    """Number of words. A name filled in is one; numbers, units and lone signs are none."""
    text = re.sub(r"\{[^{}]*:[^{}]*\}", "0", text)
    found = [word.strip("().,:;'\"") for word in MARKS.sub("{}", text).split()]
    return sum(bool(re.search(r"[^\W\d]|\{", word)) and word not in UNITS for word in found)


def length(sort, text):
    """Words of a text; of a finding with its fix in one line those of the longer part."""
    parts = re.split(r"[:;] ", text) if sort == "finding in parts" else [text]
    return max(words(part) for part in parts)


def sources(paths):
    """Rust files of the program, without its tests and benchmarks."""
    for top in paths:
        files = [top] if top.is_file() else sorted(top.rglob("*"))
        for file in files:
            parts = set(file.relative_to(ROOT).parts)
            if file.suffix == ".rs" and not parts & {"tests", "tests.rs", "benches", "examples", "target"}:
                yield file
            elif (file.suffix == ".md" and top != ROOT / "crates") or file.name == "setting_words.txt":
                yield file
            elif file.suffix == ".ipynb" or (file.suffix == ".py" and not parts & {"tests", "target"}):
                yield file


def strings(file):
    """(line, kind, text) of one file."""
    text = file.read_text(encoding="utf-8")
    if file.suffix in {".md", ".txt"}:
        yield from prose(text)
        return
    if file.suffix == ".py":
        yield from python_strings(text)
        return
    if file.suffix == ".ipynb":
        for number, cell in enumerate(json.loads(text)["cells"], 1):
            source = "".join(cell["source"])
            for _, sort, inner in python_strings(source) if cell["cell_type"] == "code" else prose(source):
                yield f"cell {number}", sort, inner
        return
    for line, position, inner in literals(text):
        # `expect(..., reason = "...")` of an attribute is for who reads the source.
        if text[max(0, position - 9) : position].endswith("reason = "):
            continue
        if words(inner) >= LEAST_WORDS and re.search(r"[a-z]{2,} [a-z]|\} [a-z]{2,}", inner):
            yield line, kind(file, text[max(0, position - 120) : position]), inner
    if "crates/cli/" in str(file):
        for line, inner in help_lines(text):
            yield line, "help", inner


def python_strings(text):
    """Strings of Python code; of a docstring each line, without code."""
    tree = ast.parse(text)
    holders = (ast.Module, ast.ClassDef, ast.FunctionDef)
    heads = {id(node.body[0].value) for node in ast.walk(tree)
             if isinstance(node, holders) and node.body and isinstance(node.body[0], ast.Expr)}
    parts = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            inner = "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in parts:
            inner = node.value
        else:
            continue
        if id(node) in heads:
            for offset, raw in enumerate(inner.split("\n")):
                if words(raw) >= LEAST_WORDS and not raw.strip().startswith((">>>", "$")):
                    yield node.lineno + offset, "doc", re.sub(r"`+[^`]*`+", "`x`", raw)
        elif words(inner) >= LEAST_WORDS and re.search(r"[a-z]{2,} [a-z]|\} [a-z]{2,}", inner):
            yield node.lineno, "text", inner


def prose(text):
    """Paragraphs of Markdown without code."""
    is_code = False
    for line, raw in enumerate(text.split("\n"), 1):
        if raw.startswith("```"):
            is_code = not is_code
        elif not is_code and not raw.startswith("    ") and words(raw) >= LEAST_WORDS:
            yield line, "prose", re.sub(r"`[^`]*`", "`x`", raw)


def breaches(kind, text):
    """Rules that a string breaks."""
    shown = MARKS.sub("{}", text)
    found = [rule for rule, pattern in FORBIDDEN if re.search(pattern, shown, re.I)]
    if kind in LONGEST and length(kind, text) > LONGEST[kind]:
        found.append(f"{kind} over {LONGEST[kind]} words")
    return found


def crate(file):
    """Name under which a file is counted."""
    parts = file.relative_to(ROOT).parts
    return "/".join(parts[:2]) if parts[0] == "crates" else parts[0]


def main():
    arguments = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    usual = [ROOT / name for name in ("src", "crates", "docs/notebooks", "CHANGELOG.md", "packaging")]
    paths = [pathlib.Path(argument).resolve() for argument in arguments] or usual
    counts, rules, lengths = {}, {}, {}
    for file in sources(paths):
        for line, sort, text in strings(file):
            name, broken = crate(file), breaches(sort, text)
            counts[name] = counts.get(name, 0) + 1
            lengths.setdefault(sort, []).append(length(sort, text))
            for rule in broken:
                rules.setdefault(rule, {}).setdefault(name, 0)
                rules[rule][name] += 1
            shown = " ".join(text.split())
            if "--list" in sys.argv:
                print(f"{file.relative_to(ROOT)}:{line} {sort}: {shown}")
            elif "--breaches" in sys.argv and broken:
                print(f"{file.relative_to(ROOT)}:{line} [{', '.join(broken)}] {shown}")
    if "--list" in sys.argv or "--breaches" in sys.argv:
        return
    print(f"{sum(counts.values())} strings of {LEAST_WORDS} words and more")
    for name, count in counts.items():
        print(f"  {name}: {count}")
    print("breaches by rule")
    for rule, by_crate in sorted(rules.items(), key=lambda item: -sum(item[1].values())):
        parts = ", ".join(f"{name} {count}" for name, count in by_crate.items())
        print(f"  {rule}: {sum(by_crate.values())} ({parts})")
    print("length, words")
    for sort, values in lengths.items():
        print(f"  {sort}: {len(values)}, median {statistics.median(values):g}, longest {max(values)}")


main()
